//! Regions: unions of cells of one label, and which of them are too small to stand alone.

mod flow;
pub(crate) mod overlap;
mod refine;
pub(crate) mod relief;
mod sheet;
pub(crate) mod terms;

use cullet_geometry::voronoi::{Cells, Face, Key, VoronoiError, WALL};
use cullet_geometry::{TriMesh, Vec3};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// One face between two cells, or between a cell and a wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet {
    /// The cell it is counter-clockwise from outside of, and the cell or wall behind it.
    pub(crate) cells: (u32, u32),
    /// When the crack passed here \[s\]; infinite where nobody knows.
    pub(crate) time: f64,
    /// Where its triangles lie in `Mosaic::triangles`.
    pub(crate) start: u32,
    pub(crate) end: u32,
}

/// A box divided into cells with shared corners: every face once, every corner once. Moving a
/// corner moves it for all cells that meet there, so they go on filling the box.
#[derive(Debug, Default)]
pub(crate) struct Mosaic {
    pub(crate) facets: Vec<Facet>,
    /// Counter-clockwise seen from outside the first cell of their facet.
    pub(crate) triangles: Vec<[u32; 3]>,
    pub(crate) places: Vec<Vec3>,
}

/// A facet, and whether it is seen from its second cell.
pub(crate) type FacetSide = (u32, bool);

impl Mosaic {
    /// Every Voronoi cell, on the current pool; the result does not depend on its size. `times`
    /// \[s\] is when the crack passed each site.
    pub(crate) fn of_cells(cells: &Cells, times: &[f64]) -> Result<Self, VoronoiError> {
        let count = cells.sites().len();
        let own = |i: u32| -> Result<Vec<Face>, VoronoiError> {
            let mut faces = cells.cell(i)?;
            faces.retain(|face| face.neighbour > i);
            Ok(faces)
        };
        let per_site: Vec<Vec<Face>> =
            (0..count as u32).into_par_iter().map(own).collect::<Result<_, _>>()?;
        let mut keys: Vec<Key> =
            per_site.iter().flatten().flat_map(|face| face.corners.iter().copied()).collect();
        keys.par_sort_unstable();
        keys.dedup();
        let places: Vec<Vec3> = keys.par_iter().map(|key| cells.position(key)).collect();
        let mut mosaic = Self { places, ..Self::default() };
        for (site, faces) in per_site.iter().enumerate() {
            for face in faces {
                let id = |key: &Key| keys.partition_point(|other| other < key) as u32;
                let ids: Vec<u32> = face.corners.iter().map(id).collect();
                let known =
                    [Some(site), (face.neighbour < WALL).then_some(face.neighbour as usize)];
                let known: Vec<f64> =
                    known.iter().flatten().map(|&s| times[s]).filter(|t| t.is_finite()).collect();
                let time = known.iter().sum::<f64>() / known.len().max(1) as f64;
                // Both sides of a facet are fanned from the same corner: one triangulation.
                let fan = (2..ids.len()).map(|k| [ids[0], ids[k - 1], ids[k]]);
                mosaic.push((site as u32, face.neighbour), time, fan);
            }
        }
        Ok(mosaic)
    }

    /// Adds a facet.
    pub(crate) fn push(
        &mut self,
        cells: (u32, u32),
        time: f64,
        triangles: impl Iterator<Item = [u32; 3]>,
    ) {
        let start = self.triangles.len() as u32;
        self.triangles.extend(triangles);
        let end = self.triangles.len() as u32;
        self.facets.push(Facet { cells, time, start, end });
    }

    /// The triangles of a facet.
    pub(crate) fn of(&self, facet: &Facet) -> &[[u32; 3]] {
        &self.triangles[facet.start as usize..facet.end as usize]
    }

    /// The facets that bound each of the labels `0..count`.
    pub(crate) fn sides(&self, labels: &[u32], count: usize) -> Vec<Vec<FacetSide>> {
        let mut sides = vec![Vec::new(); count];
        for (k, facet) in self.facets.iter().enumerate() {
            let (i, j) = facet.cells;
            let a = labels[i as usize];
            let b = (j < WALL).then(|| labels[j as usize]);
            if b != Some(a) {
                sides[a as usize].push((k as u32, false));
                if let Some(b) = b {
                    sides[b as usize].push((k as u32, true));
                }
            }
        }
        sides
    }

    /// The closed boundary of a region, and the facet that each of its triangles belongs to.
    pub(crate) fn region(&self, sides: &[FacetSide]) -> (TriMesh, Vec<u32>) {
        let mut mesh = TriMesh::default();
        let mut names = Vec::new();
        for &(name, behind) in sides {
            for &[a, b, c] in self.of(&self.facets[name as usize]) {
                mesh.triangles.push(if behind { [a, c, b] } else { [a, b, c] });
                names.push(name);
            }
        }
        let mut used: Vec<u32> = mesh.triangles.iter().flatten().copied().collect();
        used.sort_unstable();
        used.dedup();
        let local = |id: u32| used.partition_point(|&other| other < id) as u32;
        for triangle in &mut mesh.triangles {
            *triangle = triangle.map(local);
        }
        mesh.vertices = used.iter().map(|&id| self.places[id as usize]).collect();
        (mesh, names)
    }
}

/// Joins what is too small (below `floor` \[m³\], or `forced`) to the neighbour with which it
/// shares the largest area, smallest first, then goes on until at most `max` groups are left.
/// Returns the group of each item, named by its largest member; an item without neighbours stays.
pub(crate) fn agglomerate(
    volumes: &[f64],
    forced: &[bool],
    shared: &BTreeMap<(u32, u32), f64>,
    floor: f64,
    max: usize,
) -> Vec<u32> {
    let apart = vec![false; volumes.len()];
    agglomerate_apart(volumes, forced, apart, shared, (floor, max))
}

/// As [`agglomerate`], but no two of those that are to stay `apart` join.
pub(crate) fn agglomerate_apart(
    volumes: &[f64],
    forced: &[bool],
    mut apart: Vec<bool>,
    shared: &BTreeMap<(u32, u32), f64>,
    (floor, max): (f64, usize),
) -> Vec<u32> {
    let mut near: Vec<BTreeMap<u32, f64>> = vec![BTreeMap::new(); volumes.len()];
    for (&(a, b), &area) in shared {
        near[a as usize].insert(b, area);
        near[b as usize].insert(a, area);
    }
    let mut volume = volumes.to_vec();
    let mut forced = forced.to_vec();
    let mut host: Vec<u32> = (0..volumes.len() as u32).collect();
    let mut left = volumes.len();
    // Forced groups first, then by volume; the bits of numbers >= 0 sort like the numbers.
    let rank = |forced: &[bool], volume: &[f64], i: u32| {
        (!forced[i as usize], volume[i as usize].max(0.0).to_bits(), i)
    };
    let mut queue: BTreeSet<(bool, u64, u32)> =
        host.iter().map(|&i| rank(&forced, &volume, i)).collect();
    while let Some((_, _, small)) = queue.pop_first() {
        let s = small as usize;
        if !forced[s] && volume[s] >= floor && left <= max {
            break;
        }
        let free = near[s].iter().filter(|&(&t, _)| !(apart[s] && apart[t as usize]));
        let largest = free.max_by(|x, y| x.1.total_cmp(y.1).then(y.0.cmp(x.0)));
        let Some((&into, _)) = largest else { continue };
        let t = into as usize;
        queue.remove(&rank(&forced, &volume, into));
        for (third, area) in std::mem::take(&mut near[s]) {
            near[third as usize].remove(&small);
            if third != into {
                *near[third as usize].entry(into).or_insert(0.0) += area;
                *near[t].entry(third).or_insert(0.0) += area;
            }
        }
        volume[t] += volume[s];
        forced[s] = false;
        apart[t] |= apart[s];
        host[s] = into;
        left -= 1;
        queue.insert(rank(&forced, &volume, into));
    }
    name_by_largest(volumes, &host)
}

/// Follows each item to the end of its chain, then names every group by its largest member.
fn name_by_largest(volumes: &[f64], host: &[u32]) -> Vec<u32> {
    let root = |mut i: u32| {
        while host[i as usize] != i {
            i = host[i as usize];
        }
        i
    };
    let roots: Vec<u32> = (0..host.len() as u32).map(root).collect();
    let mut largest: Vec<u32> = roots.clone();
    for (i, &r) in roots.iter().enumerate() {
        if volumes[i] > volumes[largest[r as usize] as usize] {
            largest[r as usize] = i as u32;
        }
    }
    roots.iter().map(|&r| largest[r as usize]).collect()
}

/// The area of one triangle \[m²\].
pub(crate) fn triangle_area(places: &[Vec3], triangle: [u32; 3]) -> f64 {
    let [a, b, c] = triangle.map(|i| places[i as usize]);
    0.5 * (b - a).cross(&(c - a)).norm()
}

#[cfg(test)]
mod tests {
    use super::{Mosaic, agglomerate};
    use cullet_geometry::Vec3;
    use cullet_geometry::math::unit;
    use cullet_geometry::voronoi::Cells;
    use std::collections::BTreeMap;

    #[test]
    fn regions_are_closed_manifolds_that_fill_the_box() {
        let at = |i, k| 0.01 + 0.98 * unit(4, k, i);
        let sites = (0..500).map(|i| Vec3::new(at(i, 0), at(i, 1), at(i, 2))).collect();
        let cells = Cells::new(sites, Vec3::zeros(), Vec3::repeat(1.0)).unwrap();
        let mosaic = Mosaic::of_cells(&cells, &[0.0; 500]).unwrap();
        let labels: Vec<u32> = (0..500).map(|i| (unit(9, 0, i) * 7.0) as u32).collect();
        let mut sum = 0.0;
        for sides in mosaic.sides(&labels, 7) {
            let (mesh, names) = mosaic.region(&sides);
            assert!(mesh.is_closed() && names.len() == mesh.triangles.len());
            sum += mesh.signed_volume();
        }
        assert!((sum - 1.0).abs() < 1e-12, "regions sum to {sum}");
    }

    #[test]
    fn the_small_join_the_neighbour_they_share_most_with() {
        let shared = BTreeMap::from([((0, 1), 1.0), ((1, 2), 2.0), ((2, 3), 1.0), ((0, 3), 3.0)]);
        let join = |v: &[f64], floor, max| agglomerate(v, &[false; 5], &shared, floor, max);
        assert_eq!(join(&[5.0, 1.0, 4.0, 3.0, 0.1], 0.0, 9), [0, 1, 2, 3, 4]);
        // 1 joins 2; 4 is small too but touches nothing.
        assert_eq!(join(&[5.0, 1.0, 4.0, 3.0, 0.1], 2.0, 9), [0, 2, 2, 3, 4]);
        assert_eq!(join(&[5.0, 1.0, 4.0, 3.0, 0.1], 2.0, 3), [0, 2, 2, 0, 4]);
        let forced =
            agglomerate(&[5.0, 4.0], &[true, false], &BTreeMap::from([((0, 1), 1.0)]), 0.0, 9);
        assert_eq!(forced, [0, 0]);
    }
}
