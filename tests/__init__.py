"""Tests; a package, lest one of that name be found among those installed (dartpy brings one)."""
