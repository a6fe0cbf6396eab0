//! Meshes of triangles for the tests, and a linear solver for shells on them.

use cullet_geometry::Vec3;
use cullet_geometry::math::unit;
use cullet_shell::domain::ShellDomain;
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;

/// Vertices and triangles.
#[derive(Clone)]
pub(crate) struct Triangles {
    pub(crate) vertices: Vec<Vec3>,
    pub(crate) triangles: Vec<[u32; 3]>,
}

impl Triangles {
    /// A rectangle from the origin, in rows along x whose vertices are staggered; its sides are
    /// straight.
    pub(crate) fn strip(size: [f64; 2], [columns, rows]: [usize; 2]) -> Self {
        let (dx, dy) = (size[0] / columns as f64, size[1] / rows as f64);
        let row = |j: usize| -> Vec<f64> {
            let middle = (0..columns).map(|i| (i as f64 + 0.5) * dx);
            match j % 2 {
                0 => (0..=columns).map(|i| i as f64 * dx).collect(),
                _ => std::iter::once(0.0).chain(middle).chain([size[0]]).collect(),
            }
        };
        let (mut vertices, mut starts) = (Vec::new(), Vec::new());
        for j in 0..=rows {
            starts.push(vertices.len() as u32);
            vertices.extend(row(j).into_iter().map(|x| Vec3::new(x, j as f64 * dy, 0.0)));
        }
        let mut triangles = Vec::new();
        for j in 0..rows {
            let (low, high) = (starts[j], starts[j + 1]);
            // The even row has columns + 1 vertices, the odd one columns + 2.
            let (even, odd) = if j % 2 == 0 { (low, high) } else { (high, low) };
            let mut add = |[a, b, c]: [u32; 3]| {
                triangles.push(if j % 2 == 0 { [a, b, c] } else { [a, c, b] });
            };
            for i in 0..=columns as u32 {
                add([even + i, odd + i + 1, odd + i]);
                if i < columns as u32 {
                    add([even + i, even + i + 1, odd + i + 1]);
                }
            }
        }
        Self { vertices, triangles }
    }

    /// A rectangle from the origin of squares that are cut along one diagonal: vertices of the rim
    /// have six neighbours with those beyond it, and the rows go on there as inside.
    pub(crate) fn squares(size: [f64; 2], [columns, rows]: [usize; 2]) -> Self {
        let mut mesh = Self { vertices: Vec::new(), triangles: Vec::new() };
        for j in 0..=rows {
            for i in 0..=columns {
                let at = [i as f64 / columns as f64, j as f64 / rows as f64];
                mesh.vertices.push(Vec3::new(size[0] * at[0], size[1] * at[1], 0.0));
            }
        }
        for j in 0..rows {
            for i in 0..columns {
                let a = (j * (columns + 1) + i) as u32;
                let c = a + columns as u32 + 1;
                mesh.triangles.extend([[a, a + 1, c + 1], [a, c + 1, c]]);
            }
        }
        mesh
    }

    /// A tube about z from z = 0 on, of radius 1, in staggered rings.
    pub(crate) fn tube(around: usize, rows: usize, height: f64) -> Self {
        let mut mesh = Self { vertices: Vec::new(), triangles: Vec::new() };
        for j in 0..=rows {
            for i in 0..around {
                let angle = TAU * (i as f64 + 0.5 * (j % 2) as f64) / around as f64;
                let z = height * j as f64 / rows as f64;
                mesh.vertices.push(Vec3::new(angle.cos(), angle.sin(), z));
            }
        }
        let at = |i: usize, j: usize| (j * around + i % around) as u32;
        for j in 0..rows {
            for i in 0..around {
                let (a, b) = (at(i, j), at(i + 1, j));
                let (c, d) = (at(i, j + 1), at(i + 1, j + 1));
                mesh.triangles.extend(match j % 2 {
                    0 => [[a, b, c], [b, d, c]],
                    _ => [[a, b, d], [a, d, c]],
                });
            }
        }
        mesh
    }

    /// A hemisphere of radius 1 over z = 0: so many sectors meet at its pole, in `rows` rings.
    pub(crate) fn dome(sectors: usize, rows: usize) -> Self {
        let mut mesh = Self { vertices: Vec::new(), triangles: Vec::new() };
        let mut starts = Vec::new();
        for j in 0..=rows {
            starts.push(mesh.vertices.len() as u32);
            let count = (sectors * j).max(1);
            let polar = 0.25 * TAU * j as f64 / rows as f64;
            for i in 0..count {
                let angle = TAU * i as f64 / count as f64;
                let r = polar.sin();
                mesh.vertices.push(Vec3::new(r * angle.cos(), r * angle.sin(), polar.cos()));
            }
        }
        let at = |j: usize, k: usize| starts[j] + (k % (sectors * j).max(1)) as u32;
        for j in 0..rows {
            for s in 0..sectors {
                for k in 0..=j {
                    let (inner, outer) = (s * j + k, s * (j + 1) + k);
                    mesh.triangles.push([at(j, inner), at(j + 1, outer), at(j + 1, outer + 1)]);
                    if k < j {
                        let next = at(j, inner + 1);
                        mesh.triangles.push([at(j, inner), at(j + 1, outer + 1), next]);
                    }
                }
            }
        }
        mesh
    }

    /// Vertices put elsewhere.
    pub(crate) fn mapped(mut self, map: impl Fn(Vec3) -> Vec3) -> Self {
        self.vertices.iter_mut().for_each(|v| *v = map(*v));
        self
    }

    /// The same area with vertices of five to seven neighbours in no order: edges flipped at
    /// random, then vertices moved to the middle of their neighbours.
    pub(crate) fn irregular(mut self, seed: u64) -> Self {
        let rim = self.rim();
        let mut valence: BTreeMap<u32, usize> = BTreeMap::new();
        self.triangles.iter().flatten().for_each(|&v| *valence.entry(v).or_default() += 1);
        for draw in 0..2 * self.triangles.len() as u64 {
            let t = (unit(seed, 0, draw) * self.triangles.len() as f64) as usize;
            let k = (unit(seed, 1, draw) * 3.0) as usize;
            let [a, b, c] = [0, 1, 2].map(|i| self.triangles[t][(i + k) % 3]);
            let beside = |tri: &[u32; 3]| (0..3).find(|&i| tri[i] == b && tri[(i + 1) % 3] == a);
            let found = self.triangles.iter().position(|tri| beside(tri).is_some());
            let Some(other) = found else { continue };
            let d = self.triangles[other][(beside(&self.triangles[other]).unwrap() + 2) % 3];
            if [a, b, c, d].iter().any(|v| rim.contains(v))
                || valence[&a] < 6
                || valence[&b] < 6
                || valence[&c] > 6
                || valence[&d] > 6
            {
                continue;
            }
            self.triangles[t] = [a, d, c];
            self.triangles[other] = [d, b, c];
            [a, b].iter().for_each(|v| *valence.get_mut(v).unwrap() -= 1);
            [c, d].iter().for_each(|v| *valence.get_mut(v).unwrap() += 1);
        }
        for _ in 0..20 {
            let mut sums = vec![(Vec3::zeros(), 0.0); self.vertices.len()];
            for &[a, b, c] in &self.triangles {
                for (v, other) in [(a, b), (b, c), (c, a), (b, a), (c, b), (a, c)] {
                    sums[v as usize].0 += self.vertices[other as usize];
                    sums[v as usize].1 += 1.0;
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
        let edges = |t: &[u32; 3]| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])];
        let all: BTreeSet<(u32, u32)> = self.triangles.iter().flat_map(edges).collect();
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

pub(crate) type LoopShell = ShellDomain<f64, 16>;

/// Vertices held along an axis.
pub(crate) fn hold(
    shell: &LoopShell,
    vertices: impl Iterator<Item = usize>,
    axis: usize,
) -> Vec<HeldShares> {
    vertices.map(|v| HeldShares { shares: shell.surface.vertex_shares(v), axis }).collect()
}

/// Small displacements of the control points under `loads` \[N\], held by springs much stiffer
/// than the shell. Control points are eliminated along `axis`.
pub(crate) fn settled(
    shell: &mut LoopShell,
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
fn stiffness(shell: &mut LoopShell, nudge: f64) -> BTreeMap<(usize, usize), f64> {
    let nodes = shell.mass.len();
    let mut near = vec![BTreeSet::new(); nodes];
    for cell in &shell.surface.cells {
        for &a in &cell.nodes {
            near[a as usize].extend(cell.nodes.iter().map(|&b| b as usize));
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
