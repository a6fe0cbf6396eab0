#!/usr/bin/env python3
"""The stress intensity of a cone crack under a ball, by finite elements.

    pip install numpy scipy
    python tests/python/cone_crack.py

An elastic half space (held at 40 c) is pressed by Hertz' pressure of sum P inside a ring of radius
R, from which a crack of length c leaves at an angle to the surface. Elements are four-cornered and
turn about the axis; they lie along the crack. The energy released from c - h to c + h at a constant
load gives G, and chi = sqrt(E G) c^1.5 / P: the constant of `solvers/brittle/chip.rs`.
"""

import numpy as np
import scipy.sparse
import scipy.sparse.linalg

GAUSS = 3 ** -0.5
FAR = 40.0


class Mesh:
    """A wedge above the crack, what is below it, and a disc inside the ring."""

    def __init__(self, ring, angle, steps, wedge=10, below=44, disc=24):
        h = 1.0 / steps
        along = [i * h for i in range(2 * steps + 1)]
        while along[-1] < FAR:
            h *= 1.12
            along.append(along[-1] + h)
        self.steps, self.h, self.count = steps, 1.0 / steps, len(along)
        self.places = []
        self.below = np.zeros((below + 1, self.count), int)
        for k in range(below + 1):
            turn = k / below * np.pi / 2
            way = angle + (np.pi / 2 - angle) * k / below
            for j, s in enumerate(along):
                r = ring * np.cos(turn) + s * np.cos(way)
                z = ring * np.sin(turn) + s * np.sin(way)
                self.below[k, j] = self.add(0.0 if k == below else r, z)
        self.pole = self.add(ring, 0.0)
        self.wedge = np.zeros((wedge + 1, self.count), int)
        for k in range(wedge + 1):
            t = angle * k / wedge
            for j, s in enumerate(along):
                at = (ring + s * np.cos(t), s * np.sin(t))
                self.wedge[k, j] = self.pole if j == 0 else self.add(*at)
        centre = self.add(0.0, 0.0)
        self.disc = np.zeros((below + 1, disc + 1), int)
        for k in range(below + 1):
            turn = k / below * np.pi / 2
            for j in range(disc + 1):
                q = ring * j / disc
                if j in (0, disc):
                    self.disc[k, j] = self.below[k, 0] if j else centre
                else:
                    r = 0.0 if k == below else q * np.cos(turn)
                    self.disc[k, j] = self.add(r, q * np.sin(turn))
        parts = (self.below, self.wedge, self.disc)
        self.elements = np.vstack([
            np.stack([p[:-1, :-1], p[:-1, 1:], p[1:, 1:], p[1:, :-1]], 2).reshape(-1, 4)
            for p in parts
        ])
        self.x = np.array(self.places)

    def add(self, r, z):
        self.places.append((r, z))
        return len(self.places) - 1


def stiffness(mesh, nu):
    """The matrix of each element, E = 1."""
    shear = (1 - 2 * nu) / 2
    law = np.array([[1 - nu, nu, nu, 0], [nu, 1 - nu, nu, 0], [nu, nu, 1 - nu, 0], [0, 0, 0, shear]])
    law /= (1 + nu) * (1 - 2 * nu)
    x = mesh.x[mesh.elements]
    total = np.zeros((len(x), 8, 8))
    for a, b in [(a, b) for a in (-GAUSS, GAUSS) for b in (-GAUSS, GAUSS)]:
        n = np.array([(1 - a) * (1 - b), (1 + a) * (1 - b), (1 + a) * (1 + b), (1 - a) * (1 + b)]) / 4
        d = np.array([[b - 1, 1 - b, 1 + b, -1 - b], [a - 1, -1 - a, 1 + a, 1 - a]]) / 4
        jacobi = np.einsum("ik,nkj->nij", d, x)
        grad = np.einsum("nij,jk->nik", np.linalg.inv(jacobi), d)
        r = x[:, :, 0] @ n
        strain = np.zeros((len(x), 4, 8))
        strain[:, 0, 0::2] = strain[:, 3, 1::2] = grad[:, 0]
        strain[:, 1, 1::2] = strain[:, 3, 0::2] = grad[:, 1]
        strain[:, 2, 0::2] = n / r[:, None]
        weight = 2 * np.pi * r * abs(np.linalg.det(jacobi))
        total += np.einsum("nai,ab,nbj,n->nij", strain, law, strain, weight, optimize=True)
    return total


def pressed(mesh, radius):
    """Forces of sum 1 down: Hertz' pressure."""
    force, line = np.zeros(2 * len(mesh.x)), mesh.disc[0]
    for p, q in zip(line[:-1], line[1:]):
        for t in ((1 - GAUSS) / 2, (1 + GAUSS) / 2):
            width = mesh.x[q, 0] - mesh.x[p, 0]
            r = mesh.x[p, 0] + t * width
            part = r * max(0.0, 1 - (r / radius) ** 2) ** 0.5 * width
            force[2 * p + 1] += part * (1 - t)
            force[2 * q + 1] += part * t
    return force / force.sum()


def energy(mesh, matrices, force, tip):
    """Half the work of the load, with the crack open up to step `tip`."""
    same = np.arange(len(mesh.x))
    same[mesh.wedge[-1, tip:]] = mesh.below[0, tip:]
    q = same[mesh.elements]
    dof = np.stack([2 * q, 2 * q + 1], 2).reshape(-1, 8)
    rows, columns = np.repeat(dof, 8, 1).ravel(), np.tile(dof, (1, 8)).ravel()
    size = 2 * len(mesh.x)
    matrix = scipy.sparse.coo_matrix((matrices.ravel(), (rows, columns)), (size, size)).tocsr()
    held = np.ones(size, bool)
    held[dof.ravel()] = False
    held[2 * np.flatnonzero(mesh.x[:, 0] < 1e-12)] = True
    for far in same[np.concatenate([mesh.below[:, -1], mesh.wedge[:, -1]])]:
        held[2 * far : 2 * far + 2] = True
    free = np.flatnonzero(~held)
    u = scipy.sparse.linalg.spsolve(matrix[free][:, free].tocsc(), force[free])
    return force[free] @ u / 2


def chi(nu, ring, degrees=22.0, steps=60):
    angle = np.radians(degrees)
    mesh = Mesh(ring, angle, steps)
    matrices, force = stiffness(mesh, nu), pressed(mesh, ring / 1.1)
    low, high = (energy(mesh, matrices, force, steps + k) for k in (-1, 1))
    area = 4 * np.pi * mesh.h * (ring + np.cos(angle))
    return ((high - low) / area) ** 0.5


if __name__ == "__main__":
    print("chi at 22 degrees; ring over c:  0.05   0.1    0.2    0.4")
    for nu in (0.2, 0.22, 0.25, 0.3):
        print(f"  nu = {nu:4}:", *(f"{chi(nu, ring):.4f}" for ring in (0.05, 0.1, 0.2, 0.4)))
    for degrees in (15, 22, 30):
        print(f"  {degrees} degrees, ring 0.1, nu = 0.22: {chi(0.22, 0.1, degrees):.4f}")
