"""The box: its mass, and the loss channels that a scene switches on."""

from rig.catalog.entries import Rig
from rig.drive.losses import Losses, cord_coefficient, guide_force, loss_coefficients
from rig.protocol.spec import Cavity, Scene


def box_mass(cavity: Cavity, wall_density: float) -> float:
    """Return the mass of the closed box, kg: the wall lies outside the cavity on all six sides
    (rigid).

    wall_density : of a box that states neither density nor material, kg/m^3
    """
    inner = cavity.length * cavity.width * cavity.height
    thick = 2.0 * cavity.wall
    outer = (cavity.length + thick) * (cavity.width + thick) * (cavity.height + thick)
    density = wall_density if cavity.density is None else cavity.density
    return density * (outer - inner)


def losses_of(scene: Scene, rig: Rig, mass: float, frequency: float, gas: float = 0.0) -> Losses:
    """Return the loss channels that the scene switches on, with the rig's coefficients.

    frequency : of the drive, Hz; sound that a box radiates grows with its fourth power
    mass : carried by the mount: box, gauge side and bed, kg. Without a support the mount loses
        nothing
    gas : viscous equivalent of the gas drag in this filling, N s/m
    """
    own = loss_coefficients(rig, scene.cavity, frequency)
    mount = scene.support if "mount" in scene.losses else "none"
    return Losses(
        noise=own["noise"] if "noise" in scene.losses else 0.0,
        air=own["air"] if "air" in scene.losses else 0.0,
        gas=gas,
        guide=guide_force(rig.guide_friction, mass, rig.gravity) if mount == "guide" else 0.0,
        cords=cord_coefficient(rig.cord_loss_factor, rig.cord_frequency, mass)
        if mount == "cords"
        else 0.0,
    )
