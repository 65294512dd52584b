"""Packages of the wheel: the code, and beside it the scenarios and the diagrams, which live at the top of the house."""

from setuptools import find_packages, setup

SHIPPED = {f"fsm_calib._shipped.{folder}": folder for folder in ("scenarios", "diagrams")}

setup(
    packages=[*find_packages(include=["fsm_calib*"]), *SHIPPED],
    package_dir=SHIPPED,
    package_data={
        "fsm_calib": ["py.typed", "*.pyi"],
        "fsm_calib.report": ["*.j2", "*.css", "*.js"],
        "fsm_calib.watch": ["*.html", "*.css", "*.js"],
    }
    | {package: ["*.yaml", "*.json", "*.svg", "*.md", "*.mmd", "*.dot"] for package in SHIPPED},
)
