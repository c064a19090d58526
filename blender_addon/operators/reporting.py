"""Operators that report in a line what they cannot do."""

import bpy

from pavemark.errors import InputError, one_line

from ..properties.hearing import deaf


class Reporting:
    """Mixed into an operator: `act` does its work, and may raise what a person can mend."""

    def act(self, context: bpy.types.Context) -> str | None:
        """Do it; what is to be said of it, if anything."""
        raise NotImplementedError

    def execute(self, context: bpy.types.Context) -> set[str]:
        """Do it, or say why not."""
        try:
            with deaf():
                said = self.act(context)
                context.scene.pavemark.trouble = ""
        except (InputError, ValueError, OSError) as error:
            self.report({"ERROR"}, one_line(str(error)))
            return {"CANCELLED"}
        if said:
            self.report({"INFO"}, one_line(said))
        return {"FINISHED"}


def needs(cls: type, true: object, why: str) -> bool:
    """Whether something is there; if not, the reason is told where the button is."""
    if not true:
        cls.poll_message_set(why)
    return bool(true)
