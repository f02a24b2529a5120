# From a protocol to a report on the command line. Run from the repository's folder: bash examples/01_first_run.sh
rig check protocols/fill_rate.yaml --vary scene.grains.fill=[0.5,0.9]
rig run protocols/fill_rate.yaml --vary scene.grains.fill=[0.5,0.9] --set repeats.n=2 --out sessions/example
rig info sessions/example
rig report sessions/example
