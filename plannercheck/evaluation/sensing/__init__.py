"""Scenes as they are sensed, made by scripts with seeds: what the benches of clouds, maps and terrains measure on.

Read cameras.py, then rays.py (a depth image of bodies), noise.py, clouds.py (many points of one scene); buildings.py
and terrains.py stand alone.
"""
