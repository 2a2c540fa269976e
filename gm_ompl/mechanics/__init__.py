"""The fast mode decision of Sec. 3 (Eqs. (1)-(8)), compiled."""
