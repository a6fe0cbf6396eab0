//! Bonds of points, and their weights.

mod fit;
mod neighbours;

use cullet_geometry::Vec3;
use cullet_simd::{LANES, Lanes, SimdLevel, sum_lanes};
use fearless_simd::{SimdBase, dispatch, f32x16};
use fit::fitted;
use neighbours::CellOrder;
use rayon::prelude::*;
use thiserror::Error;

/// Most bytes that the bonds of a body take.
const MOST_BYTES: u64 = 4 << 30;

/// Bytes of a bond at each of its ends: the other end, two weights, two plastic extensions and what
/// is left.
pub const BOND_BYTES: u64 = 24;

/// Fewest bonds of a point: with fewer there is no shear in some direction.
const LEAST_BONDS: usize = 6;

/// Why points cannot be bonded.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BondError {
    /// There are too many bonds.
    #[error(
        "{bonds} bonds within {horizon:.3e} m take {} MB, {BOND_BYTES} bytes each; at most {} MB \
         fit: take fewer points or a shorter horizon",
        bonds * BOND_BYTES / 1_000_000,
        MOST_BYTES / 1_000_000
    )]
    TooMany {
        /// With the empty places of the lists.
        bonds: u64,
        /// δ \[m\].
        horizon: f64,
    },
    /// A point has too few.
    #[error("point {point} has {bonds} bonds within {horizon:.3e} m; it needs {LEAST_BONDS}")]
    TooFew {
        /// Which, from 0.
        point: usize,
        /// How many it has.
        bonds: usize,
        /// δ \[m\].
        horizon: f64,
    },
    /// Not every point has a volume, or there is none.
    #[error("{points} points and {volumes} volumes: there must be as many, and at least one")]
    Unequal {
        /// Points.
        points: usize,
        /// Volumes.
        volumes: usize,
    },
    /// Two points are in one place, or one's place is no number.
    #[error("point {point} lies where another does, or nowhere")]
    Coincident {
        /// The first such, from 0.
        point: usize,
    },
    /// A number does not hold.
    #[error("{what} is {value:.3e}: it must be greater than 0 and finite")]
    NoNumber {
        /// Which.
        what: &'static str,
        /// Its value.
        value: f64,
    },
}

/// That a number is greater than 0 and finite.
///
/// # Errors
///
/// If it is not.
pub(crate) fn positive(what: &'static str, value: f64) -> Result<(), BondError> {
    match value.is_finite() && value > 0.0 {
        true => Ok(()),
        false => Err(BondError::NoNumber { what, value }),
    }
}

/// The bonds of all points, each from both of its ends, in groups of sixteen.
#[derive(Clone, Debug)]
pub struct BondGraph {
    /// First group of each point, then their number.
    starts: Vec<u32>,
    /// Bonds of each point.
    counts: Vec<u32>,
    /// The other end; in lanes of a last group that are empty, that of the point's first bond.
    pub(crate) ends: Vec<Lanes<u32>>,
    /// wV over the mean volume, of this end; 0 in empty lanes \[1\].
    pub(crate) weights: Vec<Lanes<f32>>,
    /// The same of the other end.
    pub(crate) back_weights: Vec<Lanes<f32>>,
    /// Points whose bonds no positive weights make isotropic: at edges, corners and in thin places.
    pub loose: usize,
}

/// A bond as one of its ends has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondSlot {
    /// Its group.
    pub group: usize,
    /// Its lane in that.
    pub lane: usize,
    /// The other end.
    pub end: usize,
}

impl BondSlot {
    /// Its number in a list.
    #[inline(always)]
    pub(crate) fn of(self, list: &[Lanes<f32>]) -> f32 {
        list[self.group].0[self.lane]
    }
}

impl BondGraph {
    /// Bonds points within `horizon` \[m\] of each other.
    ///
    /// # Errors
    ///
    /// If a point has too few bonds, there are too many, two points coincide, or the horizon or a
    /// volume \[m³\] is none.
    pub fn new(places: &[Vec3], volumes: &[f64], horizon: f64) -> Result<Self, BondError> {
        positive("the horizon [m]", horizon)?;
        if places.is_empty() || places.len() != volumes.len() {
            return Err(BondError::Unequal { points: places.len(), volumes: volumes.len() });
        }
        if let Some(point) = places.iter().position(|x| !x.iter().all(|c| c.is_finite())) {
            return Err(BondError::Coincident { point });
        }
        volumes.iter().try_for_each(|&v| positive("a volume [m^3]", v))?;
        let order = CellOrder::new(places, horizon);
        let counts = order.counts();
        let groups: u64 = counts.iter().map(|&n| u64::from(n).div_ceil(LANES as u64)).sum();
        let bonds = groups * LANES as u64;
        if bonds * BOND_BYTES > MOST_BYTES {
            return Err(BondError::TooMany { bonds, horizon });
        }
        if let Some(point) = counts.iter().position(|&n| (n as usize) < LEAST_BONDS) {
            return Err(BondError::TooFew { point, bonds: counts[point] as usize, horizon });
        }
        let mut graph = Self::empty(counts, groups as usize);
        graph.fill(&order, places, volumes)?;
        graph.look_back();
        Ok(graph)
    }

    fn empty(counts: Vec<u32>, groups: usize) -> Self {
        let mut starts = vec![0u32];
        let mut next = 0;
        starts.extend(counts.iter().map(|n| {
            next += n.div_ceil(LANES as u32);
            next
        }));
        let none = || vec![Lanes([0.0; LANES]); groups];
        let ends = vec![Lanes([0; LANES]); groups];
        Self { starts, counts, ends, weights: none(), back_weights: none(), loose: 0 }
    }

    /// Finds the ends and weights of all points.
    fn fill(
        &mut self,
        order: &CellOrder<'_>,
        places: &[Vec3],
        volumes: &[f64],
    ) -> Result<(), BondError> {
        let mean = volumes.iter().sum::<f64>() / volumes.len() as f64;
        let (mut ends, mut weights) = (&mut self.ends[..], &mut self.weights[..]);
        let mut rows = Vec::new();
        for point in 0..places.len() {
            let groups = (self.starts[point + 1] - self.starts[point]) as usize;
            let (own, rest) = ends.split_at_mut(groups);
            let (weight, others) = weights.split_at_mut(groups);
            (ends, weights) = (rest, others);
            rows.push((point, own, weight));
        }
        let fits = rows.into_par_iter().map(|(point, ends, weights)| {
            let near = order.of(point);
            let bond = |&q: &u32| (places[q as usize] - places[point], volumes[q as usize]);
            let bonds: Vec<(Vec3, f64)> = near.iter().map(bond).collect();
            if bonds.iter().any(|(xi, _)| *xi == Vec3::zeros()) {
                return Err(BondError::Coincident { point });
            }
            let (found, fits) = fitted(&bonds);
            ends.iter_mut().for_each(|group| group.0 = [near[0]; LANES]);
            for (k, (q, w)) in near.iter().zip(found).enumerate() {
                ends[k / LANES].0[k % LANES] = *q;
                weights[k / LANES].0[k % LANES] = (w * volumes[point] / mean) as f32;
            }
            Ok(fits)
        });
        // The first point that does not hold, however many threads look.
        let fits: Vec<Result<bool, BondError>> = fits.collect();
        for fits in fits {
            self.loose += usize::from(!fits?);
        }
        Ok(())
    }

    /// Copies the weight of each bond's other end.
    fn look_back(&mut self) {
        let graph = &*self;
        let weight = |p: usize, group: usize, lane: usize| {
            let slot = BondSlot { group, lane, end: graph.ends[group].0[lane] as usize };
            match slot.of(&graph.weights) > 0.0 {
                true => graph.back(p, slot).of(&graph.weights),
                false => 0.0,
            }
        };
        let row = |p: usize| {
            let group = move |group| Lanes(std::array::from_fn(|lane| weight(p, group, lane)));
            graph.groups(p).map(group)
        };
        let found = (0..graph.counts.len()).into_par_iter().flat_map_iter(row);
        self.back_weights = found.collect();
    }

    /// The same bond from its other end.
    ///
    /// # Panics
    ///
    /// If the bond is none of the point's.
    #[must_use]
    pub fn back(&self, point: usize, bond: BondSlot) -> BondSlot {
        let first = self.starts[bond.end] as usize;
        let end = |k: usize| self.ends[first + k / LANES].0[k % LANES] as usize;
        let (mut low, mut high) = (0, self.counts[bond.end] as usize);
        while low < high {
            let middle = (low + high) / 2;
            if end(middle) < point { low = middle + 1 } else { high = middle }
        }
        assert_eq!(end(low), point, "a bond of this point");
        BondSlot { group: first + low / LANES, lane: low % LANES, end: point }
    }

    /// The groups of a point.
    #[must_use]
    #[inline(always)]
    pub fn groups(&self, point: usize) -> std::ops::Range<usize> {
        self.starts[point] as usize..self.starts[point + 1] as usize
    }

    /// The bonds of a point, by ascending other ends.
    pub fn of(&self, point: usize) -> impl Iterator<Item = BondSlot> {
        let first = self.starts[point] as usize;
        (0..self.counts[point] as usize).map(move |k| {
            let (group, lane) = (first + k / LANES, k % LANES);
            BondSlot { group, lane, end: self.ends[group].0[lane] as usize }
        })
    }

    /// Σw of a point over the mean volume, with the bits that the kernel has.
    pub(crate) fn total(&self, point: usize) -> f32 {
        let level = SimdLevel::portable().level();
        dispatch!(level, simd => {
            let zero = f32x16::splat(simd, 0.0);
            let weights = self.weights[self.groups(point)].iter();
            let sum = weights.fold(zero, |sum, w| sum + f32x16::from_slice(simd, &w.0));
            sum_lanes(simd, sum)
        })
    }

    /// Bonds of all points, each counted at both of its ends.
    #[must_use]
    pub fn count(&self) -> u64 {
        self.counts.iter().map(|&n| u64::from(n)).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::{BondError, BondGraph};
    use cullet_geometry::Vec3;

    fn lattice(n: usize) -> Vec<Vec3> {
        let at = |k: usize| Vec3::new((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64);
        (0..n * n * n).map(at).collect()
    }

    /// Each bond has its other end, and lists are those of a comparison of all with all.
    #[test]
    fn bonds_have_both_ends_and_none_is_missed() {
        let places = lattice(6);
        let graph = BondGraph::new(&places, &vec![1.0; places.len()], 2.3).unwrap();
        for p in 0..places.len() {
            let near = |q: &usize| *q != p && (places[*q] - places[p]).norm() <= 2.3;
            let wanted: Vec<usize> = (0..places.len()).filter(near).collect();
            let found: Vec<usize> = graph.of(p).map(|bond| bond.end).collect();
            assert_eq!(found, wanted);
            for bond in graph.of(p) {
                let back = graph.back(p, bond);
                assert_eq!(back.end, p);
                assert!(graph.of(bond.end).any(|other| other == back));
                assert_eq!(back.of(&graph.back_weights), bond.of(&graph.weights));
            }
            let all: f32 = graph.groups(p).flat_map(|g| graph.weights[g].0).sum();
            assert!((all - 1.0).abs() < 1e-6, "{all}");
        }
    }

    /// Lists that do not fit are refused before there are any.
    #[test]
    fn too_many_bonds_are_refused_in_words() {
        let places = lattice(30);
        let refused = BondGraph::new(&places, &vec![1.0; places.len()], 60.0).err();
        assert!(matches!(refused, Some(BondError::TooMany { bonds: 729_216_000, .. })));
        let words = refused.map(|why| why.to_string()).unwrap_or_default();
        assert!(words.contains("17501 MB") && words.contains("4294 MB"), "{words}");
    }

    #[test]
    fn what_cannot_be_bonded_is_refused() {
        let places = lattice(3);
        let volumes = vec![1.0; places.len()];
        let bonds = |volumes: &[f64], horizon| BondGraph::new(&places, volumes, horizon).err();
        let few = BondError::TooFew { point: 0, bonds: 3, horizon: 1.1 };
        assert_eq!(bonds(&volumes, 1.1), Some(few));
        assert!(matches!(bonds(&volumes, f64::NAN), Some(BondError::NoNumber { .. })));
        assert!(matches!(bonds(&[0.0; 27], 2.1), Some(BondError::NoNumber { .. })));
        assert_eq!(bonds(&[1.0], 2.1), Some(BondError::Unequal { points: 27, volumes: 1 }));
        for wrong in [places[3], Vec3::repeat(f64::NAN)] {
            let mut doubled = places.clone();
            doubled[5] = wrong;
            let refused = BondGraph::new(&doubled, &volumes, 2.1).err();
            assert!(matches!(refused, Some(BondError::Coincident { point: 3 | 5 })), "{refused:?}");
        }
    }
}
