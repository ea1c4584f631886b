"""Importing this registers the Gymnasium environment `crowdcosim/Navigation-v0`.

`gymnasium.make("crowdcosim.gym:crowdcosim/Navigation-v0", scenario="corridor")` imports it by itself.
"""

try:
    import gymnasium
except ModuleNotFoundError as error:
    raise ModuleNotFoundError("crowdcosim.gym needs Gymnasium: pip install 'crowdcosim[gym]'") from error

gymnasium.register("crowdcosim/Navigation-v0", entry_point="orchestrator.gym.navigation:Navigation")
