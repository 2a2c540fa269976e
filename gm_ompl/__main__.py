"""``python -m gm_ompl``."""

from gm_ompl.app.main import run

if __name__ == "__main__":
    run()
