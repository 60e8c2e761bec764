"""List the packages: folder `app` is installed as `observer_lab`, folder `lessons` as `observer_lab.lessons`."""

from setuptools import find_packages, setup

FOLDERS = {"observer_lab": "app", "observer_lab.lessons": "lessons"}

setup(package_dir=FOLDERS,
      packages=[name for root, folder in FOLDERS.items() for name in (root, *(f"{root}.{inner}" for inner in find_packages(folder)))])
