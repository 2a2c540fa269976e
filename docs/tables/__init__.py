"""What measures and writes the tables and pictures of the pages in ``docs/``.

Run from the checkout, ``python -m docs.tables.NAME``; no part of the installed package, which
imports nothing from here.
"""
