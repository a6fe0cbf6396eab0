//! Points of a soft shell that meet each other: those far apart on it, and those that a crack has
//! parted. They repel below a distance, which keeps folds apart; it does not stop a fast wall from
//! going through itself.

use crate::domain::ShellDomain;
use crate::midsurface::Midsurface;
use cullet_continuum::bytes::held;
use cullet_geometry::Vec3;
use std::collections::BTreeMap;

/// Distance below which points repel, in spacings, where the wall is thinner. Points are half a
/// spacing apart, and one that lies between four of another layer is 0.35 from each.
const REACH: f64 = 0.6;

/// Rings of neighbours that are too near on the shell to repel: cells up to two apart are, with all
/// their points.
const RINGS: usize = 5;

/// Stiffness by μ/dt², μ being the reduced mass: ωdt is 0.45.
const PENALTY: f64 = 0.2;

/// Most that points of two cells, and two points, may come closer until they are found anew, in
/// spacings. Cells three apart are 2.2 from each other at rest.
const MARGINS: [f64; 2] = [1.2, 0.4];

/// The points near each one on the shell before anything happens.
#[derive(Clone, Debug)]
pub(super) struct Vicinity {
    starts: Vec<u32>,
    /// Ascending for each.
    near: Vec<u32>,
    /// The same of cells, all of whose points are near each other.
    cell_starts: Vec<u32>,
    cells: Vec<u32>,
}

impl Vicinity {
    pub(super) fn new(surface: &Midsurface) -> Self {
        let (mut starts, mut near) = (vec![0], Vec::new());
        let mut met = vec![u32::MAX; surface.points()];
        for p in 0..surface.points() as u32 {
            let mut found = vec![p];
            met[p as usize] = p;
            let mut first = 0;
            for _ in 0..RINGS {
                let ring = first..found.len();
                first = found.len();
                for at in ring {
                    for &q in surface.around(found[at] as usize) {
                        if std::mem::replace(&mut met[q as usize], p) != p {
                            found.push(q);
                        }
                    }
                }
            }
            found.sort_unstable();
            near.extend(found);
            starts.push(near.len() as u32);
        }
        let (cell_starts, cells) = (vec![0], Vec::new());
        let mut vicinity = Self { starts, near, cell_starts, cells };
        for cell in 0..surface.cells.len() {
            vicinity.add_cell(cell, surface.points_per_cell());
        }
        vicinity
    }

    /// Memory that it takes \[bytes\].
    pub(super) fn bytes(&self) -> u64 {
        let lists = [&self.starts, &self.near, &self.cell_starts, &self.cells];
        lists.map(|list| held(list)).iter().sum()
    }

    fn add_cell(&mut self, cell: usize, each: usize) {
        let points = |cell: usize| (cell * each..(cell + 1) * each).map(|p| p as u32);
        let own = self.starts[cell * each] as usize..self.starts[cell * each + 1] as usize;
        let mut others: Vec<u32> = self.near[own].iter().map(|&p| p / each as u32).collect();
        others.dedup();
        others.retain(|&other| {
            points(cell).all(|p| points(other as usize).all(|q| self.has(p as usize, q)))
        });
        self.cells.extend(others);
        self.cell_starts.push(self.cells.len() as u32);
    }

    fn has_cell(&self, cell: usize, other: u32) -> bool {
        let own = self.cell_starts[cell] as usize..self.cell_starts[cell + 1] as usize;
        self.cells[own].binary_search(&other).is_ok()
    }

    fn has(&self, p: usize, q: u32) -> bool {
        let own = self.starts[p] as usize..self.starts[p + 1] as usize;
        self.near[own].binary_search(&q).is_ok()
    }
}

/// Two points that may meet, by their places in the list of those that do.
#[derive(Clone, Copy, Debug)]
struct MeetingPair {
    ends: [u32; 2],
    /// Distance below which they repel \[m\].
    distance: f64,
    /// \[N/m\].
    stiffness: f64,
}

/// Pairs of points that may meet.
#[derive(Clone, Debug, Default)]
pub(super) struct MeetingPairs {
    /// Points of pairs, ascending.
    members: Vec<u32>,
    pairs: Vec<MeetingPair>,
    /// Cells some of whose points may meet: not near each other, or parted by a crack.
    cells: Vec<[u32; 2]>,
    /// How far points of cells, and points, may still come closer until they are found anew \[m\].
    left: [f64; 2],
    is_found: bool,
    places: Vec<Vec3>,
    forces: Vec<Vec3>,
}

/// What pairs are found from.
#[derive(Clone, Copy, Debug)]
pub(super) struct PairSearch<'a> {
    pub(super) vicinity: &'a Vicinity,
    /// Mass of each point \[kg\].
    pub(super) masses: &'a [f64],
    pub(super) spacing: f64,
    pub(super) thickness: f64,
    pub(super) dt: f64,
}

impl MeetingPairs {
    /// Notes that points may have come so much closer \[m\]; whether pairs have to be found anew.
    pub(super) fn wears(&mut self, closer: f64) -> bool {
        self.left.iter_mut().for_each(|left| *left -= closer);
        !self.is_found || self.left.iter().any(|left| left.is_nan() || *left < 0.0)
    }

    /// Finds pairs anew where they have been found before: cracks have made others.
    pub(super) fn forget(&mut self) {
        self.is_found = false;
    }

    /// Finds pairs anew. Which there are beyond those that repel depends on when this is done; what
    /// forces come of them does not.
    pub(super) fn find<const N: usize>(
        &mut self,
        domain: &ShellDomain<f64, N>,
        search: &PairSearch<'_>,
    ) {
        let touching = search.thickness.max(REACH * search.spacing);
        if !self.is_found || self.left[0].is_nan() || self.left[0] < 0.0 {
            self.left[0] = MARGINS[0] * search.spacing;
            self.find_cells(domain, search, touching + self.left[0]);
            self.is_found = true;
        }
        self.left[1] = MARGINS[1] * search.spacing;
        let found = self.near_points(domain, search, touching);
        self.members = found.iter().flat_map(|pair| [pair.0, pair.1]).collect();
        self.members.sort_unstable();
        self.members.dedup();
        let place = |p: u32| self.members.binary_search(&p).unwrap_or(0) as u32;
        let pair = |&(p, q): &(u32, u32)| {
            let [m, n] = [p, q].map(|p| search.masses[p as usize]);
            let stiffness = PENALTY * (m * n / (m + n)) / (search.dt * search.dt);
            // What lies closer before anything happens is pressed together only where it comes
            // closer still.
            let [a, b] = [p, q].map(|p| domain.first_place(p as usize));
            let distance = touching.min((a - b).norm());
            MeetingPair { ends: [place(p), place(q)], distance, stiffness }
        };
        self.pairs = found.iter().map(pair).collect();
    }

    /// Finds cells whose points may be less than `reach` \[m\] apart.
    fn find_cells<const N: usize>(
        &mut self,
        domain: &ShellDomain<f64, N>,
        search: &PairSearch<'_>,
        reach: f64,
    ) {
        let each = domain.surface.points_per_cell();
        let count = domain.surface.cells.len();
        let (mut middles, mut radii) = (Vec::with_capacity(count), Vec::with_capacity(count));
        for cell in 0..count {
            let all = (cell * each..(cell + 1) * each).filter(|&p| domain.is_on(p));
            let places: Vec<Vec3> = all.map(|p| domain.place_now(p)).collect();
            let middle = places.iter().sum::<Vec3>() / places.len().max(1) as f64;
            middles.push(middle);
            radii.push(places.iter().map(|x| (x - middle).norm()).fold(0.0, f64::max));
        }
        let largest = radii.iter().copied().fold(0.0, f64::max);
        let hash = PointHash::new(&middles, reach + 2.0 * largest);
        self.cells.clear();
        for (i, middle) in middles.iter().enumerate() {
            hash.around(middle, |j| {
                let most = reach + radii[i] + radii[j as usize];
                let is_close = (middles[j as usize] - middle).norm_squared() < most * most;
                if j as usize > i && is_close && !search.vicinity.has_cell(i, j) {
                    self.cells.push([i as u32, j]);
                }
            });
        }
        let (severed, _) = domain.parted_links();
        for p in 0..domain.points() {
            let first = domain.surface.starts[p] as usize;
            for (k, &q) in domain.surface.around(p).iter().enumerate() {
                if severed[first + k] && q as usize > p {
                    let [a, b] = [p as u32, q].map(|p| p / each as u32);
                    self.cells.push([a.min(b), a.max(b)]);
                }
            }
        }
        self.cells.sort_unstable();
        self.cells.dedup();
    }

    /// Points of these cells that may meet until they are found anew, in order.
    fn near_points<const N: usize>(
        &self,
        domain: &ShellDomain<f64, N>,
        search: &PairSearch<'_>,
        touching: f64,
    ) -> Vec<(u32, u32)> {
        let each = domain.surface.points_per_cell();
        let reach = touching + self.left[1];
        let on = |p: usize| domain.is_on(p) && !domain.state(p).dead;
        let of = |cell: u32| (cell as usize * each..(cell as usize + 1) * each).filter(|&p| on(p));
        let mut places: BTreeMap<u32, Vec<(usize, Vec3)>> = BTreeMap::new();
        for &cell in self.cells.iter().flatten() {
            let now = || of(cell).map(|p| (p, domain.place_now(p))).collect();
            places.entry(cell).or_insert_with(now);
        }
        let mut found = Vec::new();
        for [i, j] in &self.cells {
            for &(p, a) in &places[i] {
                for &(q, b) in &places[j] {
                    if (b - a).norm_squared() >= reach * reach || (i == j && q <= p) {
                        continue;
                    }
                    let is_parted = || domain.joined(p).any(|(r, whole)| r == q && !whole);
                    if !search.vicinity.has(p, q as u32) || is_parted() {
                        found.push((p as u32, q as u32));
                    }
                }
            }
        }
        found
    }

    fn update<const N: usize>(&mut self, domain: &ShellDomain<f64, N>) {
        self.places.clear();
        self.places.extend(self.members.iter().map(|&p| domain.place_now(p as usize)));
    }

    /// Adds the forces of pairs to those of control points \[N\]. Where one of the two is of a
    /// piece at rest, the other's is added to `propped` too.
    pub(super) fn push<const N: usize>(
        &mut self,
        domain: &ShellDomain<f64, N>,
        frozen: impl Fn(u32) -> bool,
        forces: &mut [Vec3],
        propped: &mut Vec3,
    ) {
        if self.pairs.is_empty() {
            return;
        }
        self.update(domain);
        self.forces.clear();
        self.forces.resize(self.members.len(), Vec3::zeros());
        let mut any = false;
        for pair in &self.pairs {
            let [i, j] = pair.ends.map(|end| end as usize);
            let off = self.places[j] - self.places[i];
            let length = off.norm();
            if length >= pair.distance || length == 0.0 {
                continue;
            }
            any = true;
            let push = off * (pair.stiffness * (pair.distance - length) / length);
            self.forces[i] -= push;
            self.forces[j] += push;
            match [i, j].map(|k| frozen(self.members[k])) {
                [true, false] => *propped += push,
                [false, true] => *propped -= push,
                _ => {}
            }
        }
        if !any {
            return;
        }
        for (&p, force) in self.members.iter().zip(&self.forces) {
            if *force != Vec3::zeros() {
                let (nodes, shares) = domain.functions(p as usize);
                for (&node, share) in nodes.iter().zip(shares) {
                    forces[node as usize] += force * *share;
                }
            }
        }
    }

    /// Pairs of points that press on each other now, by their numbers.
    pub(super) fn pressed<const N: usize>(&self, domain: &ShellDomain<f64, N>) -> Vec<[u32; 2]> {
        let ends = |pair: &MeetingPair| pair.ends.map(|end| self.members[end as usize]);
        let presses = |pair: &&MeetingPair| {
            let [a, b] = ends(pair).map(|p| domain.place_now(p as usize));
            (b - a).norm() < pair.distance
        };
        self.pairs.iter().filter(presses).map(ends).collect()
    }

    /// Energy of all pairs \[J\].
    pub(super) fn energy<const N: usize>(&mut self, domain: &ShellDomain<f64, N>) -> f64 {
        self.update(domain);
        let of = |pair: &MeetingPair| {
            let [i, j] = pair.ends.map(|end| end as usize);
            let depth = (pair.distance - (self.places[j] - self.places[i]).norm()).max(0.0);
            0.5 * pair.stiffness * depth * depth
        };
        self.pairs.iter().map(of).sum()
    }
}

/// Points sorted by the cell of space that they are in.
struct PointHash {
    width: f64,
    low: Vec3,
    /// Key and number of each, rising.
    sorted: Vec<([i32; 3], u32)>,
}

impl PointHash {
    fn new(places: &[Vec3], width: f64) -> Self {
        let low = places.iter().fold(Vec3::from([f64::INFINITY; 3]), |low, p| low.inf(p));
        let mut hash = Self { width, low, sorted: Vec::new() };
        hash.sorted = places.iter().enumerate().map(|(i, p)| (hash.key(p), i as u32)).collect();
        hash.sorted.sort_unstable();
        hash
    }

    fn key(&self, p: &Vec3) -> [i32; 3] {
        // A place that has run away is found with the farthest.
        let at = ((p - self.low) / self.width).map(|c| c.clamp(-1e9, 1e9));
        [at.z as i32, at.y as i32, at.x as i32]
    }

    /// All points in the cells around a place.
    fn around(&self, place: &Vec3, mut f: impl FnMut(u32)) {
        let [z, y, x] = self.key(place);
        for (dz, dy) in (-1..=1).flat_map(|dz| (-1..=1).map(move |dy| (dz, dy))) {
            let from = [z + dz, y + dy, x - 1];
            let first = self.sorted.partition_point(|(key, _)| *key < from);
            let last = [z + dz, y + dy, x + 1];
            let row = self.sorted[first..].iter().take_while(|(key, _)| *key <= last);
            row.for_each(|&(_, i)| f(i));
        }
    }
}
