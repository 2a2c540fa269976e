"""The paper's programs stated plainly with HiGHS; a second pair of eyes on the kernel."""
