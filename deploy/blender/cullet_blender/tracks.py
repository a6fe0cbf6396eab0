"""Motion of a recording as keys: numpy only, nothing of Blender."""

import numpy as np


def at_frames(track, step, fps, frames, last):
    """Where a body is at frames: location [n, 3] and quaternion w, x, y, z [n, 4].

    A body without a row rests: it stays where it was until the step before its next row. Between two steps its place
    is on the straight line, and its turn on the shortest arc but for second order.

    Parameters
    ----------
    track : cullet.Table
        Its rows, in order of time.
    step : float
        Step of the run [s].
    fps : float
        Frames a second [1/s]; frame 0 is the start of the run.
    frames : int[n]
        Which frames.
    last : float
        The last step that counts.
    """
    steps = track.step.astype(np.float64)
    place, turn = track.position, track.rotation
    # A row a step before each gap's end, with what was there.
    gaps = np.flatnonzero(np.diff(steps) > 1)
    order = np.sort(np.concatenate([np.arange(len(steps)), gaps]), kind="stable")
    doubled = np.concatenate([[False], order[1:] == order[:-1]])
    at = steps[order]
    at[doubled] = steps[order[doubled] + 1] - 1
    place, turn = place[order], turn[order].copy()
    # One of the two quaternions of a turn: the nearer one.
    for i in range(1, len(turn)):
        if turn[i] @ turn[i - 1] < 0:
            turn[i] *= -1
    wanted = np.clip(np.asarray(frames) / fps / step, at[0], min(at[-1], last))
    location = np.column_stack([np.interp(wanted, at, place[:, axis]) for axis in range(3)])
    quaternion = np.column_stack([np.interp(wanted, at, turn[:, part]) for part in (3, 0, 1, 2)])
    return location, quaternion / np.linalg.norm(quaternion, axis=1, keepdims=True)


def needed(values, slack):
    """Which of the keys are needed: those that do not lie between two equal neighbours."""
    same = (np.abs(np.diff(values, axis=0)) <= slack).all(axis=1)
    inner = same[:-1] & same[1:]
    return np.concatenate([[True], ~inner, [True]]) if len(values) > 1 else np.array([True])
