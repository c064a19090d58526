"""Headless entry: hands the job Blender as its renderer.

With Blender as a Python module:  python render.py JOB.toml --out OUT …
With a Blender program:           blender -b -P render.py -- JOB.toml --out OUT …
"""

import sys
from pathlib import Path

SCRIPT = Path(__file__).resolve()
PROGRAM = "bpy" in sys.modules
"""Whether a Blender program runs this: it has bpy loaded. To import it would cost the run a second."""

# In the extension it lies among the panel's modules, and Blender knows where the packages are.
if (SCRIPT.parent / "pipeline").is_dir():
    sys.path[:0] = [str(SCRIPT.parent / "pipeline"), str(SCRIPT.parent)]
try:
    from pavemark import cli
    from pavemark.job.worker import serve
except ModuleNotFoundError as error:
    print(f"error: {error.name} is missing: {sys.executable} -m pip install {SCRIPT.parent}", file=sys.stderr)
    sys.exit(2)
except KeyboardInterrupt:
    sys.exit(130)


def renderer():
    """Blender, in this process, on one core."""
    from blender_addon.renderer import BlenderRenderer  # noqa: PLC0415 - workers alone load Blender

    return BlenderRenderer(threads=1)


def worker() -> list[str]:
    """The command that starts a worker."""
    if not PROGRAM:
        return [sys.executable, str(SCRIPT), "--worker"]
    blender = sys.modules["bpy"].app.binary_path
    return [blender, "-b", "--factory-startup", "--python-exit-code", "1", "-P", str(SCRIPT), "--", "--worker"]


if __name__ == "__main__":
    arguments = sys.argv[sys.argv.index("--") + 1 :] if PROGRAM else sys.argv[1:]
    if arguments == ["--worker"]:
        serve(renderer)
    else:
        cli.main(["render", *arguments], worker())
