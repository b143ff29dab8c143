"""Computation of a database from a hull, by Capytaine (the extra ``bem``); no other package imports
this one."""
