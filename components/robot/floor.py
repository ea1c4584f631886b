"""The floor that robots stand on."""

from __future__ import annotations

GRAVITY = 9.81
"""[m/s2]"""
GRIP = 0.8
"""coefficient of friction between rubber and a dry hard floor, typical [1]"""
