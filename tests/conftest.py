"""Settings of all tests."""

from __future__ import annotations

from hypothesis import HealthCheck, settings

# A machine that is busy with something else draws examples slowly: that says nothing of the code.
settings.register_profile("busy machine", suppress_health_check=[HealthCheck.too_slow], deadline=None)
settings.load_profile("busy machine")
