"""Robots that a landmarkd service localises, as vehicles of VDA 5050: `state` maps, `vehicle` speaks MQTT."""
