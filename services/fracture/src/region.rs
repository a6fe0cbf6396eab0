//! Regions: unions of Voronoi cells of one label, and which of them are too small to stand alone.

use cullet_geometry::voronoi::{Cells, Face, Key, VoronoiError, WALL};
use cullet_geometry::{Solid, Surface, TriMesh, Vec3};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};

/// Faces of less area than this share of a typical cell's squared width join nothing: cells that
/// touch along an edge only would otherwise count as neighbours (F25).
const SLIVER: f64 = 1e-6;

/// One face of the diagram, between a site and a later site or a wall.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet {
    /// The site it is counter-clockwise from outside of, and what lies behind it.
    pub(crate) sites: (u32, u32),
    /// Its area \[m²\], outside the body included.
    pub(crate) area: f64,
    /// Where its corners lie in `Mosaic::corners`.
    start: u32,
    end: u32,
}

/// All cells of a diagram with shared corners: every face once, every corner once.
#[derive(Debug)]
pub(crate) struct Mosaic {
    /// Every face once, by first site.
    pub(crate) facets: Vec<Facet>,
    corners: Vec<u32>,
    places: Vec<Vec3>,
    sliver: f64,
}

/// A facet, and whether it is seen from its second site.
pub(crate) type Side = (u32, bool);

impl Mosaic {
    /// Computes every cell, on the current pool; the result does not depend on its size.
    pub(crate) fn new(cells: &Cells) -> Result<Self, VoronoiError> {
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
        let ids: Vec<Vec<u32>> = per_site
            .par_iter()
            .map(|faces| {
                let corners = faces.iter().flat_map(|face| face.corners.iter());
                corners.map(|key| keys.partition_point(|other| other < key) as u32).collect()
            })
            .collect();
        let extent = cells.high() - cells.low();
        let width = libm::cbrt(extent.x * extent.y * extent.z / count as f64);
        let mut mosaic = Self {
            facets: Vec::new(),
            corners: Vec::new(),
            places,
            sliver: SLIVER * width * width,
        };
        for (site, (faces, ids)) in per_site.iter().zip(ids).enumerate() {
            let mut start = mosaic.corners.len();
            mosaic.corners.extend(ids);
            for face in faces {
                let end = start + face.corners.len();
                let area = mosaic.area(start, end);
                let sites = (site as u32, face.neighbour);
                mosaic.facets.push(Facet { sites, area, start: start as u32, end: end as u32 });
                start = end;
            }
        }
        Ok(mosaic)
    }

    fn area(&self, start: usize, end: usize) -> f64 {
        let at = |k: usize| self.places[self.corners[k] as usize];
        let fan = (start + 2..end).map(|k| (at(k - 1) - at(start)).cross(&(at(k) - at(start))));
        0.5 * fan.sum::<Vec3>().norm()
    }

    /// The area \[m²\] that each two labels share, slivers left out.
    pub(crate) fn shared(&self, labels: &[u32]) -> BTreeMap<(u32, u32), f64> {
        let mut shared = BTreeMap::new();
        for facet in &self.facets {
            let (i, j) = facet.sites;
            if j < WALL && facet.area > self.sliver {
                let (a, b) = (labels[i as usize], labels[j as usize]);
                if a != b {
                    *shared.entry((a.min(b), a.max(b))).or_insert(0.0) += facet.area;
                }
            }
        }
        shared
    }

    /// The facets that bound each of the labels `0..count`.
    pub(crate) fn sides(&self, labels: &[u32], count: usize) -> Vec<Vec<Side>> {
        let mut sides = vec![Vec::new(); count];
        for (k, facet) in self.facets.iter().enumerate() {
            let (i, j) = facet.sites;
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

    /// The closed boundary of a region; `tag` names the facet that a triangle belongs to.
    pub(crate) fn solid(&self, sides: &[Side], tag: impl Fn(u32) -> Surface) -> Solid {
        let ids = |side: &Side| {
            let facet = &self.facets[side.0 as usize];
            &self.corners[facet.start as usize..facet.end as usize]
        };
        let mut used: Vec<u32> = sides.iter().flat_map(|side| ids(side).iter().copied()).collect();
        used.sort_unstable();
        used.dedup();
        let local = |id: u32| used.partition_point(|&other| other < id) as u32;
        let mut solid = Solid::default();
        solid.mesh.vertices = used.iter().map(|&id| self.places[id as usize]).collect();
        for side in sides {
            let loop_: Vec<u32> = ids(side).iter().map(|&id| local(id)).collect();
            for k in 2..loop_.len() {
                // Both sides of a facet are fanned from the same corner: one triangulation.
                let [a, b, c] = [loop_[0], loop_[k - 1], loop_[k]];
                solid.mesh.triangles.push(if side.1 { [a, c, b] } else { [a, b, c] });
                solid.surface.push(tag(side.0));
            }
        }
        solid
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
        let largest = near[s].iter().max_by(|x, y| x.1.total_cmp(y.1).then(y.0.cmp(x.0)));
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
pub(crate) fn triangle_area(mesh: &TriMesh, t: usize) -> f64 {
    let [a, b, c] = mesh.corners(t);
    0.5 * (b - a).cross(&(c - a)).norm()
}

#[cfg(test)]
mod tests {
    use super::{Mosaic, agglomerate};
    use cullet_geometry::math::unit;
    use cullet_geometry::voronoi::Cells;
    use cullet_geometry::{Solid, Surface, Vec3};
    use std::collections::BTreeMap;

    fn volume(solid: &Solid) -> f64 {
        let six = |t| {
            let [a, b, c] = solid.mesh.corners(t);
            a.dot(&b.cross(&c))
        };
        (0..solid.mesh.triangles.len()).map(six).sum::<f64>() / 6.0
    }

    #[test]
    fn regions_are_closed_manifolds_that_fill_the_box() {
        let at = |i, k| 0.01 + 0.98 * unit(4, k, i);
        let sites = (0..500).map(|i| Vec3::new(at(i, 0), at(i, 1), at(i, 2))).collect();
        let cells = Cells::new(sites, Vec3::zeros(), Vec3::repeat(1.0)).unwrap();
        let mosaic = Mosaic::new(&cells).unwrap();
        let labels: Vec<u32> = (0..500).map(|i| (unit(9, 0, i) * 7.0) as u32).collect();
        let mut sum = 0.0;
        for sides in mosaic.sides(&labels, 7) {
            let solid = mosaic.solid(&sides, |_| Surface::Outer);
            let mut edges: BTreeMap<(u32, u32), i32> = BTreeMap::new();
            for &[a, b, c] in &solid.mesh.triangles {
                for (p, q) in [(a, b), (b, c), (c, a)] {
                    *edges.entry((p, q)).or_default() += 1;
                }
            }
            assert!(edges.iter().all(|(&(p, q), &n)| n == 1 && edges.get(&(q, p)) == Some(&1)));
            sum += volume(&solid);
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
