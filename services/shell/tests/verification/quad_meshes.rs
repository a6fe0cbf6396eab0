//! Meshes of quadrilaterals for the tests, and a linear solver for shells on them.

use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_shell::domain::ShellDomain;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

/// Vertices and quadrilaterals.
#[derive(Clone)]
pub(crate) struct Quads {
    pub(crate) vertices: Vec<Vec3>,
    pub(crate) quads: Vec<[u32; 4]>,
}

impl Quads {
    /// A rectangle from the origin.
    pub(crate) fn sheet(size: [f64; 2], [columns, rows]: [usize; 2]) -> Self {
        let mut mesh = Self { vertices: Vec::new(), quads: Vec::new() };
        for j in 0..=rows {
            for i in 0..=columns {
                let at = [i as f64 / columns as f64, j as f64 / rows as f64];
                mesh.vertices.push(Vec3::new(size[0] * at[0], size[1] * at[1], 0.0));
            }
        }
        let at = |i: usize, j: usize| (j * (columns + 1) + i) as u32;
        for j in 0..rows {
            for i in 0..columns {
                mesh.quads.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        mesh
    }

    /// A tube of radius 1 about z, from z = 0 to `height`, seen from outside.
    pub(crate) fn tube(around: usize, rows: usize, height: f64) -> Self {
        let mut mesh = Self { vertices: Vec::new(), quads: Vec::new() };
        for j in 0..=rows {
            for i in 0..around {
                let (sin, cos) = (TAU * i as f64 / around as f64).sin_cos();
                mesh.vertices.push(Vec3::new(cos, sin, height * j as f64 / rows as f64));
            }
        }
        let at = |i: usize, j: usize| (j * around + i % around) as u32;
        for j in 0..rows {
            for i in 0..around {
                mesh.quads.push([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        mesh
    }

    /// A disc of radius 1: `sectors` squares of `core` rows around its middle and `rings` around
    /// them. The middle has `sectors` quadrilaterals, an outer corner of each square three.
    pub(crate) fn disc(sectors: usize, core: usize, rings: usize) -> Self {
        let mut mesh = Self { vertices: vec![Vec3::zeros()], quads: Vec::new() };
        let around = 2 * sectors * core;
        // The place of a corner (i, j) of a sector; i = 0 is the j of the one before.
        let mut number: BTreeMap<(usize, usize, usize), u32> = BTreeMap::new();
        let key = |s: usize, i: usize, j: usize| match (i, j) {
            (0, 0) => (0, 0, 0),
            (i, 0) => ((s + sectors - 1) % sectors, 0, i),
            (i, j) => (s, i, j),
        };
        number.insert((0, 0, 0), 0);
        let angle = |s: usize, i: usize, j: usize| {
            let along = if i == 0 && j == 0 { 0.5 } else { j as f64 / (i + j) as f64 };
            TAU * (s as f64 + along) / sectors as f64
        };
        let inner = core as f64 / (core + rings) as f64;
        for s in 0..sectors {
            for j in 0..=core {
                for i in 0..=core {
                    let next = mesh.vertices.len() as u32;
                    if *number.entry(key(s, i, j)).or_insert(next) == next {
                        let (sin, cos) = angle(s, i, j).sin_cos();
                        let r = inner * i.max(j) as f64 / core as f64;
                        mesh.vertices.push(Vec3::new(r * cos, r * sin, 0.0));
                    }
                }
            }
        }
        let at = |s: usize, i: usize, j: usize| number[&key(s, i, j)];
        for s in 0..sectors {
            for j in 0..core {
                for i in 0..core {
                    mesh.quads.push([
                        at(s, i, j),
                        at(s, i + 1, j),
                        at(s, i + 1, j + 1),
                        at(s, i, j + 1),
                    ]);
                }
            }
        }
        // The outer line of the core, counter-clockwise.
        let mut line: Vec<u32> = Vec::new();
        for s in 0..sectors {
            line.extend((0..core).map(|j| at(s, core, j)));
            line.extend((0..core).map(|i| at(s, core - i, core)));
        }
        for ring in 1..=rings {
            let r = inner + (1.0 - inner) * ring as f64 / rings as f64;
            let next: Vec<u32> = (0..around)
                .map(|k| {
                    let (sin, cos) = (TAU * k as f64 / around as f64).sin_cos();
                    mesh.vertices.push(Vec3::new(r * cos, r * sin, 0.0));
                    mesh.vertices.len() as u32 - 1
                })
                .collect();
            for k in 0..around {
                let after = (k + 1) % around;
                mesh.quads.push([line[k], next[k], next[after], line[after]]);
            }
            line = next;
        }
        mesh.relaxed(60)
    }

    /// Half of a unit sphere, z ≥ 0, of such a disc.
    pub(crate) fn dome(sectors: usize, core: usize, rings: usize) -> Self {
        Self::disc(sectors, core, rings).mapped(|v| {
            let (r, turn) = (v.norm(), 0.25 * TAU * v.norm());
            let flat = if r > 0.0 { v / r } else { v };
            flat * turn.sin() + Vec3::z() * turn.cos()
        })
    }

    pub(crate) fn mapped(mut self, place: impl Fn(Vec3) -> Vec3) -> Self {
        self.vertices.iter_mut().for_each(|v| *v = place(*v));
        self
    }

    /// The vertices inside moved by up to a third of the distance to their neighbours, and smoothed
    /// twice.
    pub(crate) fn irregular(mut self, seed: u64) -> Self {
        let rim = self.rim();
        let near = self.quads[0].map(|v| self.vertices[v as usize]);
        let length = (near[1] - near[0]).norm();
        for (v, x) in self.vertices.iter_mut().enumerate() {
            if !rim.contains(&(v as u32)) {
                let draw = |k: u64| 0.7 * length * (unit(seed, k, v as u64) - 0.5);
                *x += Vec3::new(draw(0), draw(1), 0.0);
            }
        }
        self.relaxed(2)
    }

    /// Each vertex inside at the mean of those that it shares an edge with, so many times.
    fn relaxed(mut self, times: usize) -> Self {
        let rim = self.rim();
        for _ in 0..times {
            let mut sums = vec![(Vec3::zeros(), 0.0); self.vertices.len()];
            for quad in &self.quads {
                for k in 0..4 {
                    let (a, b) = (quad[k] as usize, quad[(k + 1) % 4] as usize);
                    sums[a].0 += self.vertices[b];
                    sums[b].0 += self.vertices[a];
                    sums[a].1 += 1.0;
                    sums[b].1 += 1.0;
                }
            }
            for (v, (sum, count)) in sums.into_iter().enumerate() {
                if !rim.contains(&(v as u32)) {
                    self.vertices[v] = sum / count;
                }
            }
        }
        self
    }

    /// Vertices of the rim.
    pub(crate) fn rim(&self) -> BTreeSet<u32> {
        let edges = |q: &[u32; 4]| [0, 1, 2, 3].map(|k| (q[k], q[(k + 1) % 4]));
        let all: BTreeSet<(u32, u32)> = self.quads.iter().flat_map(edges).collect();
        all.iter().filter(|&&(a, b)| !all.contains(&(b, a))).flat_map(|&(a, b)| [a, b]).collect()
    }

    /// The vertex nearest a place.
    pub(crate) fn nearest(&self, place: Vec3) -> usize {
        let far = |&v: &usize| (self.vertices[v] - place).norm_squared();
        (0..self.vertices.len()).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap()
    }
}

/// A linear combination of the displacements of control points along an axis that a support holds.
pub(crate) struct HeldShares {
    pub(crate) shares: Vec<(u32, f64)>,
    pub(crate) axis: usize,
}

pub(crate) type QuadShell = ShellDomain<f64, 12>;

/// Vertices held along an axis.
pub(crate) fn hold(
    shell: &QuadShell,
    vertices: impl Iterator<Item = usize>,
    axis: usize,
) -> Vec<HeldShares> {
    vertices.map(|v| HeldShares { shares: shell.surface.vertex_shares(v), axis }).collect()
}

/// Small displacements of the control points under `loads` \[N\], held by springs much stiffer
/// than the shell. Control points are eliminated along `axis`.
pub(crate) fn settled(
    shell: &mut QuadShell,
    loads: &[Vec3],
    held: &[HeldShares],
    axis: usize,
    nudge: f64,
) -> Vec<Vec3> {
    let nodes = shell.mass.len();
    let mut order: Vec<usize> = (0..nodes).collect();
    order.sort_by(|&a, &b| shell.surface.nodes[a][axis].total_cmp(&shell.surface.nodes[b][axis]));
    let mut place = vec![0; nodes];
    order.iter().enumerate().for_each(|(k, &n)| place[n] = k);
    let mut rows = stiffness(shell, nudge);
    let stiffest = rows.values().fold(0.0_f64, |most, k| most.max(k.abs()));
    for one in held {
        for &(a, s) in &one.shares {
            for &(b, t) in &one.shares {
                let key = (3 * a as usize + one.axis, 3 * b as usize + one.axis);
                *rows.entry(key).or_default() += 1e5 * stiffest * s * t;
            }
        }
    }
    let number = |dof: usize| 3 * place[dof / 3] + dof % 3;
    let width = rows.keys().map(|&(a, b)| number(a).abs_diff(number(b))).max().unwrap();
    let size = 3 * nodes;
    // Row by row, the lower half.
    let mut band = vec![0.0; size * (width + 1)];
    for (&(a, b), &k) in &rows {
        let (i, j) = (number(a), number(b));
        if j <= i {
            band[i * (width + 1) + j + width - i] = k;
        }
    }
    // A control point that nothing holds stays.
    (0..size).for_each(|i| band[i * (width + 1) + width] += 1e-13 * stiffest);
    let mut u = vec![0.0; size];
    for (n, load) in loads.iter().enumerate() {
        (0..3).for_each(|c| u[3 * place[n] + c] = load[c]);
    }
    cholesky(&mut band, width, &mut u);
    (0..nodes).map(|n| Vec3::from([0, 1, 2].map(|c| u[3 * place[n] + c]))).collect()
}

/// Solves for `u` with a banded positive definite matrix.
fn cholesky(band: &mut [f64], width: usize, u: &mut [f64]) {
    let (n, w) = (u.len(), width + 1);
    for i in 0..n {
        let low = i.saturating_sub(width);
        let (done, rest) = band.split_at_mut(i * w);
        let row = &mut rest[..w];
        for j in low..i {
            let from = low.max(j.saturating_sub(width));
            let other = &done[j * w..(j + 1) * w];
            let (a, b) = (&row[from + width - i..j + width - i], &other[from + width - j..width]);
            let sum: f64 = dot(a, b);
            row[j + width - i] = (row[j + width - i] - sum) / other[width];
        }
        let sum = dot(&row[low + width - i..width], &row[low + width - i..width]);
        row[width] = (row[width] - sum).max(f64::MIN_POSITIVE).sqrt();
        let before: f64 = (low..i).map(|j| row[j + width - i] * u[j]).sum();
        u[i] = (u[i] - before) / row[width];
    }
    for i in (0..n).rev() {
        let row = &band[i * w..(i + 1) * w];
        u[i] /= row[width];
        let value = u[i];
        for j in i.saturating_sub(width)..i {
            u[j] -= row[j + width - i] * value;
        }
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    for (a, b) in a.chunks(8).zip(b.chunks(8)) {
        for (sum, (a, b)) in sums.iter_mut().zip(a.iter().zip(b)) {
            *sum += a * b;
        }
    }
    sums.iter().sum()
}

/// −∂f/∂u by central differences, control points that are far apart at a time.
fn stiffness(shell: &mut QuadShell, nudge: f64) -> BTreeMap<(usize, usize), f64> {
    let nodes = shell.mass.len();
    let mut near = vec![BTreeSet::new(); nodes];
    for cell in &shell.surface.cells {
        for &a in &cell.nodes[..12] {
            near[a as usize].extend(cell.nodes[..12].iter().map(|&b| b as usize));
        }
    }
    let mut colours: Vec<Vec<usize>> = Vec::new();
    let mut colour = vec![usize::MAX; nodes];
    for n in 0..nodes {
        let around = near[n].iter().flat_map(|&m| near[m].iter());
        let taken: BTreeSet<usize> = around.map(|&m| colour[m]).collect();
        let free = (0..).find(|c| !taken.contains(c)).unwrap();
        colour[n] = free;
        colours.resize(colours.len().max(free + 1), Vec::new());
        colours[free].push(n);
    }
    let mut entries = BTreeMap::new();
    for group in &colours {
        for axis in 0..3 {
            let mut side = |sign: f64| -> Vec<Vec3> {
                group.iter().for_each(|&n| shell.displacement[n][axis] = sign * nudge);
                shell.strain();
                group.iter().for_each(|&n| shell.displacement[n][axis] = 0.0);
                (0..nodes).map(|n| shell.force(n)).collect()
            };
            let (more, less) = (side(1.0), side(-1.0));
            for &n in group {
                for &m in &near[n] {
                    let change = (less[m] - more[m]) / (2.0 * nudge);
                    (0..3).for_each(|c| {
                        entries.insert((3 * m + c, 3 * n + axis), change[c]);
                    });
                }
            }
        }
    }
    entries
}
