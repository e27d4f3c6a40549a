"""Files that people have: tables, TUM, bags, MCAP, PathWeaver, Choreo and URDF."""

from nfopidn.formats.csv import read_csv
from nfopidn.formats.frc import read_choreo, read_pathweaver, write_pathweaver
from nfopidn.formats.log import Log
from nfopidn.formats.mcap import write_mcap
from nfopidn.formats.rosbags import read_bag
from nfopidn.formats.tum import read_tum, write_tum
from nfopidn.formats.urdf import RobotDescription, read_urdf

__all__ = [
    "Log",
    "RobotDescription",
    "read_bag",
    "read_choreo",
    "read_csv",
    "read_pathweaver",
    "read_tum",
    "read_urdf",
    "write_mcap",
    "write_pathweaver",
    "write_tum",
]
