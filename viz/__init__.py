"""Pictures of a plan; installs as ``gm_ompl.viz``."""
