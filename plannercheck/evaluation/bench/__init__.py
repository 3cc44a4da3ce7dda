"""Measurements of `plannercheck bench`: run time against error, beside other methods and libraries.

Every module measures one thing and returns rows (frozen dataclasses); tables.py prints them, writes CSV, and plots.py
draws. Contenders take turns in one process (timing.py), so that ratios hold on a loaded machine.

Measurements take `rounds`, the turns of each contender; `seed`, that of their random numbers; and `skipped` or `note`,
which is told why a method is left out.
"""
