"""Tests: they mirror mbconstrained/, with independent values in oracles/, theorems in properties/, house rules in audits/."""
