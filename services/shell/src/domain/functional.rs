//! A place in a shell as a linear function of its control points: what a force there does to them,
//! and how fast it moves.

use super::state::ShellDomain;
use cullet_geometry::{Mat3, Vec3};
use cullet_simd::Real;

/// Shares of control points in the speed of a place along a direction.
#[derive(Clone, Debug, Default)]
pub(crate) struct Functional {
    /// Control point and its share; control points in ascending order.
    terms: Vec<(u32, Vec3)>,
}

impl Functional {
    /// One less the other.
    pub(crate) fn minus(&self, other: &Self) -> Self {
        let mut terms = self.terms.clone();
        for &(node, share) in &other.terms {
            match terms.binary_search_by_key(&node, |t| t.0) {
                Ok(k) => terms[k].1 -= share,
                Err(k) => terms.insert(k, (node, -share)),
            }
        }
        Self { terms }
    }

    /// Speed along the direction \[m/s\].
    pub(crate) fn speed(&self, velocity: &[Vec3]) -> f64 {
        self.terms.iter().map(|(node, share)| share.dot(&velocity[*node as usize])).sum()
    }

    /// What a unit of impulse changes the speed by \[1/kg\].
    pub(crate) fn mobility(&self, mass: &[f64]) -> f64 {
        self.terms.iter().map(|(n, share)| share.norm_squared() / mass[*n as usize]).sum()
    }

    /// Gives an impulse along the direction \[N·s\].
    pub(crate) fn push(&self, impulse: f64, velocity: &mut [Vec3], mass: &[f64]) {
        for (node, share) in &self.terms {
            velocity[*node as usize] += share * (impulse / mass[*node as usize]);
        }
    }
}

/// The surface at a point now.
pub(crate) struct PresentPoint {
    pub(crate) moved: Vec3,
    tangents: [Vec3; 2],
    normal: Vec3,
    stretch: f64,
    /// a₃ − A₃.
    pub(crate) turned: Vec3,
}

impl<R: Real, const N: usize> ShellDomain<R, N> {
    /// The surface at a point now.
    pub(crate) fn present(&self, point: usize) -> PresentPoint {
        let (_, table) = self.surface.at(point);
        let nodes = &self.elements[self.element_of(point)].nodes;
        let sum = |row: &[f64]| -> Vec3 {
            nodes.iter().zip(row).map(|(&n, share)| self.moved(n as usize) * *share).sum()
        };
        let surface = &self.setup[self.seats[point]].surface;
        let tangents = [0, 1].map(|d| surface.tangents[d] + sum(&table.derivatives[d]));
        let across = tangents[0].cross(&tangents[1]);
        let stretch = across.norm();
        let normal = across / stretch;
        let turned = normal - surface.normal;
        PresentPoint { moved: sum(&table.value), tangents, normal, stretch, turned }
    }

    /// Where a place beside a point, as it lay at first, is now: what the midsurface carries, and
    /// its height over that, where the wall is thinner as the midsurface is wider \[m\].
    #[must_use]
    pub fn carried(&self, point: usize, place: &Vec3) -> [Vec3; 2] {
        let (surface, now) = (&self.setup[self.seats[point]].surface, self.present(point));
        let [a1, a2] = surface.tangents;
        let first = Mat3::from_columns(&[a1, a2, surface.normal]);
        let off = place - surface.place;
        let off = first.try_inverse().map_or(Vec3::zeros(), |first| first * off);
        let [b1, b2] = now.tangents;
        let thinner = surface.stretch / now.stretch;
        [surface.place + now.moved + b1 * off.x + b2 * off.y, now.normal * (thinner * off.z)]
    }

    /// Where a point was before anything moved \[m\].
    #[must_use]
    pub fn first_place(&self, point: usize) -> Vec3 {
        self.setup[self.seats[point]].surface.place
    }

    /// Where a point is now \[m\].
    #[must_use]
    pub fn place_now(&self, point: usize) -> Vec3 {
        let (nodes, shares) = self.functions(point);
        let moved: Vec3 = nodes.iter().zip(shares).map(|(&n, s)| self.moved(n as usize) * *s).sum();
        self.first_place(point) + moved
    }

    /// Area of a point now, along its normal \[m²\].
    #[must_use]
    pub fn area_vector(&self, point: usize) -> Vec3 {
        let (surface, now) = (&self.setup[self.seats[point]].surface, self.present(point));
        now.normal * (surface.area * now.stretch / surface.stretch)
    }

    /// The speed along `direction` of the place at the height `z` \[m\] over the midsurface at a
    /// point: δ(x + z a₃) with δa₃ = (1 − a₃a₃ᵀ)(δa₁ × a₂ + a₁ × δa₂)/j.
    pub(crate) fn functional(&self, point: usize, z: f64, direction: &Vec3) -> Functional {
        let (_, table) = self.surface.at(point);
        let now = self.present(point);
        let nodes = &self.elements[self.element_of(point)].nodes;
        let along = direction - now.normal * now.normal.dot(direction);
        let lever = along * (z / now.stretch);
        let (first, second) = (now.tangents[1].cross(&lever), lever.cross(&now.tangents[0]));
        let mut terms: Vec<(u32, Vec3)> = Vec::with_capacity(N);
        for (k, &node) in nodes.iter().enumerate() {
            let share = direction * table.value[k]
                + first * table.derivatives[0][k]
                + second * table.derivatives[1][k];
            match terms.binary_search_by_key(&node, |t| t.0) {
                Ok(at) => terms[at].1 += share,
                Err(at) => terms.insert(at, (node, share)),
            }
        }
        Functional { terms }
    }
}
