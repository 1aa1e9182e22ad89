"""Fixtures of all tests."""

from fixtures import _no_key_from_outside, client, folder, home, pytest_configure, service

__all__ = ["_no_key_from_outside", "client", "folder", "home", "pytest_configure", "service"]
