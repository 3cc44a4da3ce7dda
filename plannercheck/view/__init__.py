"""Pictures: a robot in its scene, what collides in red, and the planes and points that prove it.

In: a checker and configurations, or a path. Out: a `Picture`, which `write_page` puts into one HTML file that needs no
network, and `serve` into a browser through viser (`pip install 'plannercheck[view]'`).
"""

from plannercheck.view.frames import along_path as along_path
from plannercheck.view.joints import joints_of as joints_of
from plannercheck.view.page import Picture as Picture
from plannercheck.view.page import write_page as write_page
from plannercheck.view.picture import picture as picture
from plannercheck.view.server import serve as serve
from plannercheck.view.surfaces import delivered_meshes as delivered_meshes
from plannercheck.view.surfaces import visual_meshes as visual_meshes

__all__ = ["Picture", "along_path", "delivered_meshes", "joints_of", "picture", "serve", "visual_meshes", "write_page"]
