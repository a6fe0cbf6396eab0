//! Bonds of points, and their weights.

mod fit;

use cullet_geometry::Vec3;
use fit::fitted;
use rayon::prelude::*;
use thiserror::Error;

/// Most bonds of a body.
const MOST_BONDS: usize = 200_000_000;

/// Fewest bonds of a point: with fewer there is no shear in some direction.
const LEAST_BONDS: usize = 6;

/// Why points cannot be bonded.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum BondError {
    /// There are too many bonds.
    #[error("{bonds} bonds within {horizon:.3e} m; at most {MOST_BONDS} fit")]
    TooMany {
        /// At least so many.
        bonds: usize,
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
    #[error("{what} is {value:.3e}: it must be positive and finite")]
    NoNumber {
        /// Which.
        what: &'static str,
        /// Its value.
        value: f64,
    },
}

/// The bonds of all points, each from both of its ends.
#[derive(Clone, Debug)]
pub struct BondGraph {
    /// First bond of each point, then their number.
    pub starts: Vec<u32>,
    /// The other end.
    pub ends: Vec<u32>,
    /// The same bond from its other end.
    pub back: Vec<u32>,
    /// l₀ \[m\].
    pub rest: Vec<f64>,
    /// w \[1\].
    pub weights: Vec<f64>,
    /// Points whose bonds no positive weights make isotropic: at edges, corners and in thin places.
    pub loose: usize,
}

impl BondGraph {
    /// Bonds points within `horizon` \[m\] of each other.
    ///
    /// # Errors
    ///
    /// If a point has too few bonds, there are too many, two points coincide, or the horizon or a
    /// volume \[m³\] is none.
    pub fn new(places: &[Vec3], volumes: &[f64], horizon: f64) -> Result<Self, BondError> {
        let number = |what, value: f64| match value.is_finite() && value > 0.0 {
            true => Ok(()),
            false => Err(BondError::NoNumber { what, value }),
        };
        number("the horizon [m]", horizon)?;
        if places.is_empty() || places.len() != volumes.len() {
            return Err(BondError::Unequal { points: places.len(), volumes: volumes.len() });
        }
        if let Some(point) = places.iter().position(|x| !x.iter().all(|c| c.is_finite())) {
            return Err(BondError::Coincident { point });
        }
        volumes.iter().try_for_each(|&v| number("a volume [m^3]", v))?;
        let near = neighbours(places, horizon)?;
        let mut starts = vec![0u32];
        for (point, near) in near.iter().enumerate() {
            if near.len() < LEAST_BONDS {
                return Err(BondError::TooFew { point, bonds: near.len(), horizon });
            }
            if near.iter().any(|&q| places[q as usize] == places[point]) {
                return Err(BondError::Coincident { point });
            }
            starts.push(starts[point] + near.len() as u32);
        }
        let found: Vec<(Vec<f64>, bool)> = near
            .par_iter()
            .enumerate()
            .map(|(point, near)| {
                let bonds: Vec<(Vec3, f64)> = near
                    .iter()
                    .map(|&q| (places[q as usize] - places[point], volumes[q as usize]))
                    .collect();
                fitted(&bonds)
            })
            .collect();
        let loose = found.iter().filter(|(_, fits)| !fits).count();
        let weights = found.into_iter().flat_map(|(weights, _)| weights).collect();
        let ends: Vec<u32> = near.iter().flatten().copied().collect();
        let ways = |point: usize| near[point].iter().map(move |&q| (point, q as usize));
        let rest = (0..places.len()).flat_map(ways).map(|(p, q)| (places[q] - places[p]).norm());
        let place = |p: usize, q: usize| near[q].partition_point(|&r| (r as usize) < p) as u32;
        let back = (0..places.len()).flat_map(ways).map(|(p, q)| starts[q] + place(p, q));
        let (rest, back) = (rest.collect(), back.collect());
        Ok(Self { starts, ends, back, rest, weights, loose })
    }

    /// The bonds of a point.
    #[must_use]
    pub fn of(&self, point: usize) -> std::ops::Range<usize> {
        self.starts[point] as usize..self.starts[point + 1] as usize
    }
}

/// The points within `horizon` of each, ascending.
fn neighbours(places: &[Vec3], horizon: f64) -> Result<Vec<Vec<u32>>, BondError> {
    let low = places.iter().fold(Vec3::repeat(f64::INFINITY), |low, x| low.inf(x));
    // What is farther than any cell is counted in the last: distances decide.
    let cell = |x: &Vec3| (x - low).map(|d| (d / horizon).min(1e15) as i64);
    let key = |c: &nalgebra::Vector3<i64>| [c.x, c.y, c.z];
    let mut order: Vec<([i64; 3], u32)> =
        places.iter().enumerate().map(|(p, x)| (key(&cell(x)), p as u32)).collect();
    order.sort_unstable();
    let near = |point: usize| -> Vec<u32> {
        let (x, at) = (&places[point], cell(&places[point]));
        let mut found = Vec::new();
        for step in 0..9 {
            let (i, j) = (at.x + step / 3 - 1, at.y + step % 3 - 1);
            let first = order.partition_point(|entry| entry.0 < [i, j, at.z - 1]);
            let column = order[first..].iter().take_while(|entry| entry.0 <= [i, j, at.z + 1]);
            let reached = |q: &u32| {
                *q as usize != point
                    && (places[*q as usize] - x).norm_squared() <= horizon * horizon
            };
            found.extend(column.map(|entry| entry.1).filter(reached));
        }
        found.sort_unstable();
        found
    };
    let all: Vec<Vec<u32>> = (0..places.len()).into_par_iter().map(near).collect();
    let bonds = all.iter().map(Vec::len).sum();
    if bonds > MOST_BONDS {
        return Err(BondError::TooMany { bonds, horizon });
    }
    Ok(all)
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
            let wanted: Vec<u32> = (0..places.len()).filter(near).map(|q| q as u32).collect();
            assert_eq!(&graph.ends[graph.of(p)], &wanted[..]);
            for bond in graph.of(p) {
                let back = graph.back[bond] as usize;
                assert_eq!(graph.ends[back] as usize, p);
                assert!(graph.of(graph.ends[bond] as usize).contains(&back));
            }
        }
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
