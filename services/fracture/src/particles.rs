//! Material points as a structure of arrays.

use crate::mpm::symmetric::Sym3;
use cullet_geometry::{Mat3, Vec3};

/// The points of a body. Arrays are parallel; their order changes when the grid re-bins them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// Mass of a point over its reference volume \[kg/m³\].
    pub density: f64,
    /// Place in the order in which the points were given.
    pub id: Vec<u32>,
    /// Reference volume \[m³\]: the weight of the point in every integral over the body.
    pub volume: Vec<f64>,
    /// Position \[m\]; f64 in the body's own frame, so that a strain of 1e-12 still moves it.
    pub position: Vec<Vec3>,
    /// Position before the hit \[m\].
    pub reference: Vec<Vec3>,
    /// Velocity \[m/s\].
    pub velocity: Vec<Vec3>,
    /// APIC velocity gradient C, zero at the start \[1/s\].
    pub affine: Vec<Mat3>,
    /// H = F − I \[1\].
    pub displacement_gradient: Vec<Mat3>,
    /// Weakened Kirchhoff stress \[Pa\].
    pub stress: Vec<Sym3>,
    /// Damage, never falling \[1\].
    pub damage: Vec<f64>,
    /// When damage reached 1 \[s\]; infinite where it has not.
    pub damage_time: Vec<f64>,
    /// Strain rate when damage began, the norm of sym C \[1/s\]; zero where it has not.
    pub onset_rate: Vec<f64>,
    /// Local strength over the body's \[1\].
    pub strength: Vec<f64>,
    /// From when on a crack may be near \[s\]; infinite where none has come yet.
    pub front_time: Vec<f64>,
    /// Under a striker: undamaged while in compression (F11).
    pub shielded: Vec<bool>,
}

/// The points of one block, to be changed apart from the others.
pub(crate) struct View<'a> {
    pub(crate) volume: &'a [f64],
    pub(crate) position: &'a mut [Vec3],
    pub(crate) velocity: &'a mut [Vec3],
    pub(crate) affine: &'a mut [Mat3],
    pub(crate) displacement_gradient: &'a mut [Mat3],
    pub(crate) stress: &'a mut [Sym3],
    pub(crate) damage: &'a mut [f64],
    pub(crate) damage_time: &'a mut [f64],
    pub(crate) onset_rate: &'a mut [f64],
    pub(crate) strength: &'a [f64],
    pub(crate) front_time: &'a [f64],
    pub(crate) shielded: &'a [bool],
}

impl Particles {
    /// Points at rest and unstrained that share `body_volume` \[m³\] and its mass evenly.
    #[must_use]
    pub fn at_rest(positions: &[Vec3], body_volume: f64, density: f64) -> Self {
        let n = positions.len();
        let volume = body_volume / n.max(1) as f64;
        Self {
            density,
            id: (0..n as u32).collect(),
            volume: vec![volume; n],
            position: positions.to_vec(),
            reference: positions.to_vec(),
            velocity: vec![Vec3::zeros(); n],
            affine: vec![Mat3::zeros(); n],
            displacement_gradient: vec![Mat3::zeros(); n],
            stress: vec![[0.0; 6]; n],
            damage: vec![0.0; n],
            damage_time: vec![f64::INFINITY; n],
            onset_rate: vec![0.0; n],
            strength: vec![1.0; n],
            front_time: vec![0.0; n],
            shielded: vec![false; n],
        }
    }

    /// How many.
    #[must_use]
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }

    /// Puts the points in the order `order[new] = old`.
    pub(crate) fn reorder(&mut self, order: &[u32]) {
        pick(&mut self.id, order);
        pick(&mut self.volume, order);
        pick(&mut self.position, order);
        pick(&mut self.reference, order);
        pick(&mut self.velocity, order);
        pick(&mut self.affine, order);
        pick(&mut self.displacement_gradient, order);
        pick(&mut self.stress, order);
        pick(&mut self.damage, order);
        pick(&mut self.damage_time, order);
        pick(&mut self.onset_rate, order);
        pick(&mut self.strength, order);
        pick(&mut self.front_time, order);
        pick(&mut self.shielded, order);
    }

    /// Cuts the arrays at `starts` (first point of each block, then the number of points).
    pub(crate) fn views(&mut self, starts: &[u32]) -> Vec<View<'_>> {
        let mut position = self.position.as_mut_slice();
        let mut velocity = self.velocity.as_mut_slice();
        let mut affine = self.affine.as_mut_slice();
        let mut displacement_gradient = self.displacement_gradient.as_mut_slice();
        let mut stress = self.stress.as_mut_slice();
        let mut damage = self.damage.as_mut_slice();
        let mut damage_time = self.damage_time.as_mut_slice();
        let mut onset_rate = self.onset_rate.as_mut_slice();
        starts
            .windows(2)
            .map(|pair| {
                let range = pair[0] as usize..pair[1] as usize;
                let n = range.len();
                View {
                    position: take(&mut position, n),
                    velocity: take(&mut velocity, n),
                    affine: take(&mut affine, n),
                    displacement_gradient: take(&mut displacement_gradient, n),
                    stress: take(&mut stress, n),
                    damage: take(&mut damage, n),
                    damage_time: take(&mut damage_time, n),
                    onset_rate: take(&mut onset_rate, n),
                    volume: &self.volume[range.clone()],
                    strength: &self.strength[range.clone()],
                    front_time: &self.front_time[range.clone()],
                    shielded: &self.shielded[range],
                }
            })
            .collect()
    }

    /// Linear momentum \[kg·m/s\].
    #[must_use]
    pub fn momentum(&self) -> Vec3 {
        let pairs = self.velocity.iter().zip(&self.volume);
        pairs.fold(Vec3::zeros(), |sum, (v, volume)| sum + v * *volume) * self.density
    }

    /// Angular momentum about the origin \[kg·m²/s\], with the part that APIC keeps in C:
    /// m h²/4 Σ ε:C, since Σ w (x_i − x_p)(x_i − x_p)ᵀ = h²/4 I.
    #[must_use]
    pub fn angular_momentum(&self, spacing: f64) -> Vec3 {
        let own = 0.25 * spacing * spacing;
        let mut sum = Vec3::zeros();
        for (p, (x, v)) in self.position.iter().zip(&self.velocity).enumerate() {
            sum += (x.cross(v) + twist(&self.affine[p]) * own) * self.volume[p];
        }
        sum * self.density
    }

    /// Kinetic energy \[J\], with the part in C.
    #[must_use]
    pub fn kinetic_energy(&self, spacing: f64) -> f64 {
        let own = 0.25 * spacing * spacing;
        let pairs = self.velocity.iter().zip(&self.affine).zip(&self.volume);
        let sum: f64 = pairs
            .map(|((v, c), volume)| volume * (v.norm_squared() + own * c.norm_squared()))
            .sum();
        0.5 * self.density * sum
    }

    /// Mass of a point \[kg\].
    #[must_use]
    #[inline]
    pub fn mass(&self, p: usize) -> f64 {
        self.density * self.volume[p]
    }
}

/// The axial vector (C₃₂ − C₂₃, C₁₃ − C₃₁, C₂₁ − C₁₂) of a velocity gradient \[1/s\].
#[must_use]
pub(crate) fn twist(c: &Mat3) -> Vec3 {
    Vec3::new(c[(2, 1)] - c[(1, 2)], c[(0, 2)] - c[(2, 0)], c[(1, 0)] - c[(0, 1)])
}

fn pick<T: Copy>(array: &mut Vec<T>, order: &[u32]) {
    *array = order.iter().map(|&old| array[old as usize]).collect();
}

fn take<'a, T>(rest: &mut &'a mut [T], n: usize) -> &'a mut [T] {
    let (head, tail) = std::mem::take(rest).split_at_mut(n);
    *rest = tail;
    head
}
