"""Trajectories that can be driven: from waypoints, and from logs of states."""

from nfopidn.trajectories.limits import Limits, Use, uses
from nfopidn.trajectories.states import from_states
from nfopidn.trajectories.waypoints import Plan, from_waypoints, plan_waypoints

__all__ = ["Limits", "Plan", "Use", "from_states", "from_waypoints", "plan_waypoints", "uses"]
