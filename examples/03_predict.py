"""What the model says, without a test: W_T against acceleration, friction and collision apart."""

from rig import conditions, load_protocol, load_rig, predict

protocol = load_protocol(
    "schema: rig/protocol/1\nname: levels\n",
    varies=["drive.acceleration=[2 m/s^2, 4 m/s^2, 6 m/s^2]"],
)
rig = load_rig(protocol.rig)
for condition in conditions(protocol):
    found = predict(condition, rig)
    parts = f"friction {1e3 * found.W_f:.1f}, collision {1e3 * found.W_c:.1f}, at most {1e3 * found.bound:.1f}"
    print(
        f"{condition.drive.acceleration:g} m/s^2: W_T = {1e3 * found.W_T:.1f} mJ per cycle ({parts})"
    )
