"""The stress suite: families of hard pairs, and every verdict held against exact arithmetic.

Data flows families, contacts -> specimens -> draws -> run (with peers) -> tables; `cases` keeps what fails.
"""
