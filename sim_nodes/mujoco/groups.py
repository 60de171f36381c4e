"""Groups of geoms, by which rays and images select them. Collision shapes are drawn only without visuals."""

SOLID_GROUP, VISUAL_GROUP, HIDDEN_GROUP = 0, 1, 3
SEEN_BY_RAYS = (SOLID_GROUP, HIDDEN_GROUP)
DRAWN_GROUPS = (SOLID_GROUP, VISUAL_GROUP)
