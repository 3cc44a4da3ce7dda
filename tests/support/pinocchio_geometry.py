"""Collision geometry as Pinocchio itself reads it, through coal and assimp: what our own reading is held against."""

import pinocchio as pin

from plannercheck.common.package_files import folders_above


def pinocchio_geometry(model, urdf, package_dirs=()):
    """Pinocchio's geometries of a URDF file, without pairs."""
    folders = [str(folder) for folder in (*package_dirs, *folders_above(urdf))]
    return pin.buildGeomFromUrdf(model, str(urdf), pin.COLLISION, package_dirs=folders)
