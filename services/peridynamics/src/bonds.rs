//! Bonds of points, and their weights.

mod fit;
pub(crate) mod neighbours;

use crate::anisotropy::{QUARTIC, isotropic};
use cullet_continuum::bytes::held;
use cullet_geometry::Vec3;
use cullet_simd::{LANES, Lanes, SimdLevel, WINDOW, sum_lanes};
use fearless_simd::{SimdBase, dispatch, f32x16};
use fit::fitted;
use neighbours::CellOrder;
use rayon::prelude::*;
use thiserror::Error;

/// Most bytes that the bonds of a body take.
const MOST_BYTES: u64 = 4 << 30;

/// Bytes of a bond at each of its ends: the other end, two weights, two plastic extensions and what
/// is left.
pub const BOND_BYTES: u64 = 22;

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
    /// First bond of each group: its other end.
    pub(crate) bases: Vec<u32>,
    /// Other ends from there; in empty lanes that of the group's first bond.
    pub(crate) ends: Vec<[u16; LANES]>,
    /// wV over the mean volume, of this end; 0 in empty lanes, and only there \[1\].
    pub(crate) weights: Vec<Lanes<f32>>,
    /// The same of the other end.
    pub(crate) back_weights: Vec<Lanes<f32>>,
    /// Points whose bonds no positive weights fit to the moments: at edges, corners and in thin
    /// places.
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
    /// Memory that it takes \[bytes\].
    pub(crate) fn bytes(&self) -> u64 {
        let weights = held(&self.weights) + held(&self.back_weights);
        held(&self.starts) + held(&self.bases) + held(&self.ends) + weights
    }

    /// Bonds points within `horizon` \[m\] of each other.
    ///
    /// # Errors
    ///
    /// If a point has too few bonds, there are too many, two points coincide, or the horizon or a
    /// volume \[m³\] is none.
    pub fn new(places: &[Vec3], volumes: &[f64], horizon: f64) -> Result<Self, BondError> {
        Self::with_moments(places, volumes, horizon, &isotropic())
    }

    /// The same with weights whose fourth moments Σw n⊗n⊗n⊗n are `moments`.
    ///
    /// # Errors
    ///
    /// As [`BondGraph::new`].
    pub fn with_moments(
        places: &[Vec3],
        volumes: &[f64],
        horizon: f64,
        moments: &[f64; QUARTIC],
    ) -> Result<Self, BondError> {
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
        let fit = |bonds: u64| match bonds * BOND_BYTES > MOST_BYTES {
            true => Err(BondError::TooMany { bonds, horizon }),
            false => Ok(()),
        };
        fit(counts.iter().map(|&n| u64::from(n)).sum())?;
        if let Some(point) = counts.iter().position(|&n| (n as usize) < LEAST_BONDS) {
            return Err(BondError::TooFew { point, bonds: counts[point] as usize, horizon });
        }
        let groups = |point: usize| grouped(&order.of(point)).count() as u32;
        let groups: Vec<u32> = (0..places.len()).into_par_iter().map(groups).collect();
        fit(groups.iter().map(|&n| u64::from(n) * LANES as u64).sum())?;
        let mut graph = Self::empty(&groups);
        graph.fill(&order, places, volumes, moments)?;
        graph.look_back();
        Ok(graph)
    }

    fn empty(groups: &[u32]) -> Self {
        let mut starts = vec![0u32];
        let mut next = 0;
        starts.extend(groups.iter().map(|n| {
            next += n;
            next
        }));
        let none = || vec![Lanes([0.0; LANES]); next as usize];
        let (bases, ends) = (vec![0; next as usize], vec![[0; LANES]; next as usize]);
        Self { starts, bases, ends, weights: none(), back_weights: none(), loose: 0 }
    }

    /// Finds the ends and weights of all points.
    fn fill(
        &mut self,
        order: &CellOrder<'_>,
        places: &[Vec3],
        volumes: &[f64],
        moments: &[f64; QUARTIC],
    ) -> Result<(), BondError> {
        let mean = volumes.iter().sum::<f64>() / volumes.len() as f64;
        let (mut ends, mut weights) = (&mut self.ends[..], &mut self.weights[..]);
        let mut bases = &mut self.bases[..];
        let mut rows = Vec::new();
        for point in 0..places.len() {
            let groups = (self.starts[point + 1] - self.starts[point]) as usize;
            let (base, rest) = bases.split_at_mut(groups);
            let (own, after) = ends.split_at_mut(groups);
            let (weight, others) = weights.split_at_mut(groups);
            (bases, ends, weights) = (rest, after, others);
            rows.push((point, base, own, weight));
        }
        let fits = rows.into_par_iter().map(|(point, bases, ends, weights)| {
            let near = order.of(point);
            let bond = |&q: &u32| (places[q as usize] - places[point], volumes[q as usize]);
            let bonds: Vec<(Vec3, f64)> = near.iter().map(bond).collect();
            if bonds.iter().any(|(xi, _)| *xi == Vec3::zeros()) {
                return Err(BondError::Coincident { point });
            }
            let (found, fits) = fitted(&bonds, moments);
            let mut found = found.into_iter();
            let own = bases.iter_mut().zip(ends).zip(weights);
            for (((base, ends), weights), group) in own.zip(grouped(&near)) {
                *base = group[0];
                for (lane, q) in group.iter().enumerate() {
                    let w = found.next().unwrap_or_default() * volumes[point] / mean;
                    ends[lane] = (q - group[0]) as u16;
                    weights.0[lane] = (w as f32).max(f32::MIN_POSITIVE);
                }
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
            let slot = graph.slot(group, lane);
            let back = slot.and_then(|slot| graph.find(slot.end, p));
            back.map_or(0.0, |back| back.of(&graph.weights))
        };
        let row = |p: usize| {
            let group = move |group| Lanes(std::array::from_fn(|lane| weight(p, group, lane)));
            graph.groups(p).map(group)
        };
        let found = (0..graph.starts.len() - 1).into_par_iter().flat_map_iter(row);
        self.back_weights = found.collect();
    }

    /// The bond in a lane of a group, where there is one.
    fn slot(&self, group: usize, lane: usize) -> Option<BondSlot> {
        let end = self.bases[group] as usize + self.ends[group][lane] as usize;
        (self.weights[group].0[lane] > 0.0).then_some(BondSlot { group, lane, end })
    }

    /// The bond of a point to another, if there is one, broken or not.
    #[must_use]
    pub fn find(&self, point: usize, end: usize) -> Option<BondSlot> {
        let groups = self.groups(point);
        let behind = self.bases[groups.clone()].partition_point(|&base| base as usize <= end);
        let group = groups.start + behind.checked_sub(1)?;
        (0..LANES).filter_map(|lane| self.slot(group, lane)).find(|slot| slot.end == end)
    }

    /// The groups of a point.
    #[must_use]
    #[inline(always)]
    pub fn groups(&self, point: usize) -> std::ops::Range<usize> {
        self.starts[point] as usize..self.starts[point + 1] as usize
    }

    /// The bonds of a point, by ascending other ends.
    pub fn of(&self, point: usize) -> impl Iterator<Item = BondSlot> {
        let lanes = move |group| (0..LANES).filter_map(move |lane| self.slot(group, lane));
        self.groups(point).flat_map(lanes)
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
        let real = |group: &Lanes<f32>| group.0.iter().filter(|&&w| w > 0.0).count() as u64;
        self.weights.iter().map(real).sum()
    }
}

/// Ascending ends in groups of sixteen or fewer that one window of records holds.
fn grouped(ends: &[u32]) -> impl Iterator<Item = &[u32]> {
    let mut rest = ends;
    std::iter::from_fn(move || {
        let first = *rest.first()?;
        let near = rest.iter().take(LANES).take_while(|&&q| ((q - first) as usize) < WINDOW);
        let (group, after) = rest.split_at(near.count());
        rest = after;
        Some(group)
    })
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
                let back = graph.find(bond.end, p).unwrap();
                assert_eq!(back.end, p);
                assert!(graph.of(bond.end).any(|other| other == back));
                assert_eq!(back.of(&graph.back_weights), bond.of(&graph.weights));
            }
            let all: f32 = graph.groups(p).flat_map(|g| graph.weights[g].0).sum();
            assert!((all - 1.0).abs() < 1e-6, "{all}");
        }
    }

    /// Ends that are far from each other in the list are in groups of their own.
    #[test]
    fn ends_far_apart_lie_in_their_own_groups() {
        let ends = [3, 5, 70_000, 135_535, 135_536, 201_072];
        let found: Vec<&[u32]> = super::grouped(&ends).collect();
        assert_eq!(found, [&ends[..2], &ends[2..4], &ends[4..5], &ends[5..]]);
        let many: Vec<u32> = (0..40).collect();
        assert_eq!(super::grouped(&many).map(<[u32]>::len).collect::<Vec<_>>(), [16, 16, 8]);
    }

    /// Lists that do not fit are refused before there are any.
    #[test]
    fn too_many_bonds_are_refused_in_words() {
        let places = lattice(30);
        let refused = BondGraph::new(&places, &vec![1.0; places.len()], 60.0).err();
        assert!(matches!(refused, Some(BondError::TooMany { bonds: 728_973_000, .. })));
        let words = refused.map(|why| why.to_string()).unwrap_or_default();
        assert!(words.contains("16037 MB") && words.contains("4294 MB"), "{words}");
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
