//! What a soft shell looks like: each point draws its quarter of its cell, and quarters that whole
//! links join share their corners. So the surface comes apart where cracks have parted the shell.

use crate::domain::ShellDomain;
use crate::midsurface::Midsurface;
use cullet_continuum::bytes::held;
use cullet_geometry::Vec3;
use cullet_model::MovingSurface;

/// Corners closer than this before anything moved are one, over the side of a cell \[1\].
const SAME: f64 = 1e-3;

/// Corners of a point's quarter, by the point's place in its cell: numbers in the 3×3 places of
/// [`crate::midsurface::CellTable::corners`], counter-clockwise.
const QUARTERS: [[usize; 4]; 4] = [[0, 1, 4, 3], [1, 2, 5, 4], [3, 4, 7, 6], [4, 5, 8, 7]];

/// Corners of a quarter.
const CORNERS: usize = 4;

/// Which corners of quarters are the same place before anything moves.
#[derive(Clone, Debug)]
pub(super) struct DrawnLattice {
    /// For entries of the midsurface's list of neighbours: two corners, as point times four plus
    /// corner, that are one where the link is whole.
    same: Vec<(u32, [u32; 2])>,
    /// Coordinates of each corner for textures \[m\].
    reference: Vec<[f32; 2]>,
}

impl DrawnLattice {
    /// Of a surface of quadrilaterals.
    pub(super) fn new(surface: &Midsurface, axes: &[Vec3; 2]) -> Self {
        let points = surface.points();
        let place = |p: usize, k: usize| {
            let (cell, _) = surface.at(p);
            let row = &corner_row(surface, p, k);
            surface.sum(cell, &row[..], &surface.nodes)
        };
        let places: Vec<[Vec3; CORNERS]> =
            (0..points).map(|p| std::array::from_fn(|k| place(p, k))).collect();
        let mut same = Vec::new();
        for p in 0..points {
            let side = surface.surface_point(p).extent;
            for (entry, &q) in surface.around(p).iter().enumerate() {
                if (q as usize) < p {
                    continue;
                }
                let entry = surface.starts[p] + entry as u32;
                for (i, a) in places[p].iter().enumerate() {
                    for (j, b) in places[q as usize].iter().enumerate() {
                        if (a - b).norm() < SAME * side {
                            let corner = |p: usize, k: usize| (CORNERS * p + k) as u32;
                            same.push((entry, [corner(p, i), corner(q as usize, j)]));
                        }
                    }
                }
            }
        }
        let flat = |x: &Vec3| [x.dot(&axes[0]) as f32, x.dot(&axes[1]) as f32];
        let reference = places.iter().flatten().map(flat).collect();
        Self { same, reference }
    }

    /// Memory that it takes \[bytes\].
    pub(super) fn bytes(&self) -> u64 {
        held(&self.same) + held(&self.reference)
    }
}

/// Functions of a cell at a corner of a point's quarter.
fn corner_row(
    surface: &Midsurface,
    point: usize,
    corner: usize,
) -> [f64; cullet_geometry::nurbs::MOST_FUNCTIONS] {
    let (cell, _) = surface.at(point);
    let place = QUARTERS[point % surface.points_per_cell()][corner];
    surface.tables[cell.table as usize].corners[place]
}

/// The surface that a shell has come to.
#[derive(Clone, Debug)]
pub(super) struct PartedSurface {
    pub(super) surface: MovingSurface,
    /// What it was made from: links that were severed, and points that bore nothing.
    severed: Vec<bool>,
    dead: Vec<bool>,
    /// Corners of quarters by vertex.
    starts: Vec<u32>,
    corners: Vec<u32>,
}

impl PartedSurface {
    pub(super) fn new<const N: usize>(
        lattice: &DrawnLattice,
        domain: &ShellDomain<f64, N>,
        thickness: f64,
    ) -> Self {
        let (severed, dead) = domain.parted_links();
        let points = domain.points();
        let drawn = |p: usize| domain.is_on(p) && !dead[p];
        let mut root: Vec<u32> = (0..(CORNERS * points) as u32).collect();
        for &(entry, [a, b]) in &lattice.same {
            let both = [a, b].iter().all(|&c| drawn(c as usize / CORNERS));
            if both && !severed[entry as usize] {
                let (a, b) = (find(&mut root, a), find(&mut root, b));
                root[a.max(b) as usize] = a.min(b);
            }
        }
        let mut vertex = vec![u32::MAX; root.len()];
        let mut of: Vec<Vec<u32>> = Vec::new();
        let mut surface = MovingSurface { thickness: thickness as f32, ..MovingSurface::default() };
        for c in (0..root.len() as u32).filter(|&c| drawn(c as usize / CORNERS)) {
            let first = find(&mut root, c) as usize;
            if vertex[first] == u32::MAX {
                vertex[first] = of.len() as u32;
                of.push(Vec::new());
                surface.reference.push(lattice.reference[first]);
            }
            vertex[c as usize] = vertex[first];
            of[vertex[first] as usize].push(c);
        }
        for p in (0..points).filter(|&p| drawn(p)) {
            let [a, b, c, d] = std::array::from_fn(|k| vertex[CORNERS * p + k]);
            surface.triangles.extend([[a, b, c], [a, c, d]]);
        }
        let mut starts = vec![0];
        let mut corners = Vec::new();
        for own in of {
            corners.extend(own);
            starts.push(corners.len() as u32);
        }
        let (severed, dead) = (severed.to_vec(), dead.to_vec());
        Self { surface, severed, dead, starts, corners }
    }

    /// Whether it is still that of the shell.
    pub(super) fn holds<const N: usize>(&self, domain: &ShellDomain<f64, N>) -> bool {
        let (severed, dead) = domain.parted_links();
        self.severed == severed && self.dead == dead
    }

    /// The point that each of its triangles is of.
    pub(super) fn owners<const N: usize>(&self, domain: &ShellDomain<f64, N>) -> Vec<u32> {
        let drawn = (0..domain.points()).filter(|&p| domain.is_on(p) && !self.dead[p]);
        drawn.flat_map(|p| [p as u32; 2]).collect()
    }

    /// Mean thickness of the points at each of its vertices, before anything moved \[m\].
    pub(super) fn thickness<const N: usize>(&self, domain: &ShellDomain<f64, N>) -> Vec<f64> {
        let of = |two: &[u32]| {
            let own = &self.corners[two[0] as usize..two[1] as usize];
            let at = |&c: &u32| domain.state(c as usize / CORNERS).thickness;
            own.iter().map(at).sum::<f64>() / own.len() as f64
        };
        self.starts.windows(2).map(of).collect()
    }

    /// Where its vertices are now \[m\].
    pub(super) fn places<const N: usize>(&self, domain: &ShellDomain<f64, N>) -> Vec<Vec3> {
        let (_, now) = domain.node_places();
        let corner = |c: u32| -> Vec3 {
            let p = c as usize / CORNERS;
            let row = corner_row(&domain.surface, p, c as usize % CORNERS);
            let nodes = domain.functions(p).0;
            nodes.iter().zip(&row).map(|(&n, share)| now[n as usize] * *share).sum()
        };
        let of = |two: &[u32]| {
            let own = &self.corners[two[0] as usize..two[1] as usize];
            own.iter().map(|&c| corner(c)).sum::<Vec3>() / own.len() as f64
        };
        self.starts.windows(2).map(of).collect()
    }
}

/// The first corner that one is the same as.
fn find(root: &mut [u32], corner: u32) -> u32 {
    let mut at = corner;
    while root[at as usize] != at {
        root[at as usize] = root[root[at as usize] as usize];
        at = root[at as usize];
    }
    at
}
