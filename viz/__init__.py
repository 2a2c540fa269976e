"""Pictures of a plan; installs as ``gm_ompl.viz``.

``animation`` turns a plan into a timeline of plain numbers. From it ``scene`` makes meshcat's
messages, ``page`` one stand-alone HTML file, ``figures`` and ``snapshots`` images by matplotlib.
"""
