"""The penalty method again, with numpy: in what is solid of a closed mesh a spring pulls the hand to the nearest place of the
surface."""

import numpy as np

import haptics_method as hm


def rotate(q, v):
    w, u = q[0], np.array(q[1:])
    return v + 2 * (w * np.cross(u, v) + np.cross(u, np.cross(u, v)))


def dot(a, b):
    return np.einsum("...i,...i", a, b)


class Penalty:
    def load(self, bodies, hip):
        self.bodies = bodies
        for body in bodies:
            body.corners = np.array(body.vertices)[np.array(body.triangles)]
            body.edges = np.roll(body.corners, -1, axis=1) - body.corners
            body.normals = np.cross(body.edges[:, 0], body.edges[:, 1])
            a, b, c = np.moveaxis(body.corners, 1, 0)
            body.solid_above = np.copysign(2 * np.pi, dot(a, np.cross(b, c)).sum())

    def place(self, hip):
        pass

    def tick(self, poses, hip):
        hip, deepest, best, stiffness = np.array(hip), 0, None, 0
        for body, (rotation, position) in zip(self.bodies, poses):
            h = rotate((rotation[0], *(-x for x in rotation[1:])), hip - position)
            if not body.closed or not is_solid_at(body, h):
                continue
            foot = nearest(body, h)
            depth = np.linalg.norm(foot - h)
            if depth > deepest:
                deepest, best, stiffness = depth, rotate(rotation, foot) + position, body.stiffness_N_per_m
        if best is None:
            return 0, (0, 0, 0), hip
        return hm.TOUCHING, stiffness * (best - hip), best


def is_solid_at(body, h):
    """All triangles of a closed mesh together are seen under 4 pi from inside and 0 from outside; of a room, which face
    inwards, under -4 pi and 0."""
    a, b, c = np.moveaxis(body.corners - h, 1, 0)
    la, lb, lc = (np.linalg.norm(x, axis=1) for x in (a, b, c))
    angle = np.arctan2(dot(a, np.cross(b, c)), la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
    return 2 * angle.sum() > body.solid_above


def nearest(body, h):
    """Of each triangle its foot in the plane, or on each edge; the nearest of all that lie in it."""
    off = h - body.corners
    within = (dot(np.cross(body.normals[:, None], body.edges), off) > 0).all(axis=1)
    along = np.clip(dot(off, body.edges) / dot(body.edges, body.edges), 0, 1)
    places = (body.corners + along[..., None] * body.edges).reshape(-1, 3)
    normals = body.normals[within]
    heights = dot(normals, off[within, 0]) / dot(normals, normals)
    places = np.concatenate([places, h - heights[:, None] * normals])
    return places[np.argmin(dot(places - h, places - h))]


hm.serve(Penalty(), "penalty_python", f"example, numpy {np.__version__}", hm.MOVING_BODIES | hm.OPEN_MESHES | hm.EDITS)
