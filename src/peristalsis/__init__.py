"""Electromechanical model of colonic propulsion: waves, wall, pellet."""
