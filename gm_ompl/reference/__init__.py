"""The paper's programs and search stated plainly with HiGHS; a second pair of eyes."""
