"""What inpainting networks want and give: one table, and a network is known by its inputs and outputs.

All take `image` [1, 3, H, W] in R, G, B and `mask` [1, 1, H, W]; they differ in type, size, polarity and range.
"""

from __future__ import annotations

import attrs
import numpy as np

from pavemark.errors import InputError
from pavemark.onnx import Network, Port

SMALLEST = 64
"""Pixels a side to which a smaller image is mirrored: networks halve it thrice, and mirror what they halved."""

OFF = 25.0
"""Mean grey levels by which a network may miss pixels that it was shown. Where it reads the mask the other way round,
or knows another range, it misses a trial's by 50 and more."""


BLACK = 8
"""Grey levels below which all of a hole amid middle greys is not filled."""


@attrs.frozen
class Contract:
    """A kind of inpainting network.

    Attributes
    ----------
    name : str
    type : str
        Of the elements of inputs and output: "float" or "uint8".
    output : str
        Name of the output, [1, 3, H, W].
    side : int or None
        Height and width that the graph is fixed to; None where it takes any.
    crop : int
        Pixels a side of the largest image that it is shown, at native scale.
    whole : bool
        It is always shown crop × crop pixels. Others see multiples of 8.
    white : float or None
        White in the output; None where files of this kind differ, see `measured_white`.
    hole, known : float
        Values of the mask.
    bare : bool
        Black lies under the hole. MI-GAN blends its fill into what lies there: it gets the nearest ground.
    """

    name: str
    type: str
    output: str
    side: int | None
    crop: int
    whole: bool
    white: float | None
    hole: float = 1.0
    known: float = 0.0
    bare: bool = True

    def fits(self, network: Network) -> bool:
        """Whether a network's inputs and outputs are of this kind."""
        inputs = {port.name: port for port in network.inputs}
        # Only the first output counts; onnxruntime opens graphs that have none.
        outputs = [(port.name, port.type) for port in network.outputs[:1]]
        return (
            inputs.keys() == {"image", "mask"}
            and self._takes(inputs["image"], 3)
            and self._takes(inputs["mask"], 1)
            and outputs == [(self.output, self.type)]
        )

    def _takes(self, port: Port, channels: int) -> bool:
        # The number of images and of channels may be left free by whoever exported the graph.
        return (
            port.type == self.type
            and len(port.shape) == 4
            and port.shape[0] in (None, 1)
            and port.shape[1] in (None, channels)
            and port.shape[2:] == (self.side, self.side)
        )

    def fill(self, network: Network, white: float, image: np.ndarray, hole: np.ndarray) -> np.ndarray:
        """What a network puts into a hole.

        Parameters
        ----------
        network : Network
            One that fits.
        white : float
            White in its output.
        image : ndarray (H, W, 3) uint8
            At most `crop` pixels a side, display sRGB. In the hole lies ground that may be looked at.
        hole : ndarray (H, W) bool

        Returns
        -------
        ndarray (H, W, 3) float32
            Levels from 0 to 255; what it means outside the hole is the network's affair.

        Raises
        ------
        InputError
            As `Network.run`.
        """
        height, width = hole.shape
        rows, columns = ((self.crop if self.whole else max(SMALLEST, -(-side // 8) * 8)) for side in hole.shape)
        margin = ((0, rows - height), (0, columns - width))
        image = np.pad(image, (*margin, (0, 0)), mode="symmetric")
        hole = np.pad(hole, margin, mode="symmetric")
        mask = np.where(hole, self.hole, self.known)[None, None]
        shown = np.where(hole & self.bare, 0, image.transpose(2, 0, 1))[None]
        if self.type == "uint8":
            feeds = {"image": np.ascontiguousarray(shown, np.uint8), "mask": mask.astype(np.uint8)}
        else:
            feeds = {"image": (shown / 255).astype(np.float32), "mask": mask.astype(np.float32)}
        result = network.run(feeds, (1, 3, rows, columns))[0, :, :height, :width].transpose(1, 2, 0)
        return np.clip(result.astype(np.float32) * (255 / white), 0, 255)


CONTRACTS = {
    contract.name: contract
    for contract in (
        Contract("lama-512", "float", "output", side=512, crop=512, whole=True, white=None),
        # 640 lets an image of 600 × 600 pass in one piece; memory and time grow with the area.
        Contract("lama-dynamic", "float", "output", side=None, crop=640, whole=False, white=None),
        # The graph takes any size, and squeezes it to 512 × 512.
        Contract("migan", "uint8", "result", None, 512, whole=True, white=255, hole=0, known=255, bare=False),
        Contract("pavemark", "float", "filled", side=None, crop=640, whole=False, white=1),
    )
}
"""The kinds of networks by name."""


def recognised(network: Network) -> Contract:
    """The contract that a network fits.

    Raises
    ------
    InputError
        With the network's inputs and outputs, and those that are allowed.
    """
    for contract in CONTRACTS.values():
        if contract.fits(network):
            return contract
    here = f"{', '.join(map(str, network.inputs))} → {', '.join(map(str, network.outputs))}"
    allowed = "; ".join(
        f"{one.name}: image {one.type} [1, 3, {one.side or '?'}, {one.side or '?'}], mask with 1 channel → {one.output}"
        for one in CONTRACTS.values()
    )
    raise InputError(network.path, f"has {here}: allowed are {allowed}")


def measured_white(network: Network, contract: Contract) -> float:
    """Show a network a coloured picture with a hole: it has to give back what it was shown, and to fill the rest.

    Returns
    -------
    float
        White in its output: the contract's, else 1 or 255, whichever it is.

    Raises
    ------
    InputError
        When known pixels do not come back, so that mask, range or channels must be others than the contract's, or when
        the hole comes back as black as it was shown. How good a fill is, is not judged.
    """
    side = contract.crop if contract.whole else 256
    rng = np.random.default_rng(0)
    blocks = rng.integers(40, 216, (side // 32, side // 32, 3)).astype(np.uint8)
    image = blocks.repeat(32, axis=0).repeat(32, axis=1)
    hole = np.zeros((side, side), bool)
    hole[96:160, 96:160] = True
    whites = (1.0, 255.0) if contract.white is None else (float(contract.white),)
    fills = {white: contract.fill(network, white, image, hole) for white in whites}
    offs = {white: float(np.abs(filled - image)[~hole].mean()) for white, filled in fills.items()}
    white = min(offs, key=offs.get)
    if offs[white] > OFF:
        raise InputError(
            network.path,
            f"misses pixels that it is shown by {offs[white]:.0f} grey levels on average: mask, value range or channels"
            f" are not those of {contract.name}",
        )
    if contract.bare and fills[white][hole].max() < BLACK:
        raise InputError(network.path, "leaves the hole black, as it was shown it: a network that fills it is allowed")
    return white
