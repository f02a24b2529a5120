"""What pyproject.toml cannot say: `protocols/`, a folder at the top, is installed as a folder of
`rig`.
"""

from setuptools import find_namespace_packages, find_packages, setup

setup(
    packages=[
        *find_packages(include=["rig*", "daq*", "analysis*"]),
        *(f"rig.{folder}" for folder in find_namespace_packages(include=["protocols*"])),
    ],
    package_dir={"rig.protocols": "protocols"},
)
