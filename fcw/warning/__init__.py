"""Warnings: rules, policies, and the levels that a person is shown."""
