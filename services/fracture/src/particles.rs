//! Material points as a structure of arrays.

use crate::mpm::flow::FlowState;
use cullet_geometry::Vec3;

/// The points of a body. Arrays are parallel; the grid puts them in the order of its
/// elements.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Particles {
    /// Mass of a point over its reference volume, by kind of material \[kg/m³\].
    pub density: Vec<f64>,
    /// Which material each point is of.
    pub kind: Vec<u8>,
    /// Place in the order in which the points were given.
    pub id: Vec<u32>,
    /// Reference volume \[m³\]: the weight of the point in every integral over the body.
    pub volume: Vec<f64>,
    /// Position before the hit \[m\].
    pub reference: Vec<Vec3>,
    /// Damage, never falling \[1\].
    pub damage: Vec<f64>,
    /// When damage reached 1 \[s\]; infinite where it has not.
    pub damage_time: Vec<f64>,
    /// Strain rate when damage began, the norm of sym ∇v \[1/s\]; zero where it has not.
    pub onset_rate: Vec<f64>,
    /// Unit normal of the crack where damage has begun; else zero.
    pub normal: Vec<Vec3>,
    /// Local strength over the body's \[1\].
    pub strength: Vec<f64>,
    /// From when on a crack may be near \[s\]; infinite where none has come yet.
    pub front_time: Vec<f64>,
    /// Under a striker: undamaged while in compression (F11).
    pub shielded: Vec<bool>,
    /// Broken and torn apart: bears nothing any more, whatever its nodes do.
    pub eroded: Vec<bool>,
    /// What flow has left; empty where nothing flows.
    pub flow: Vec<FlowState>,
}

/// Some of the points, borrowed so that they are changed apart from the others.
pub(crate) struct ParticlesMut<'a> {
    pub(crate) kind: &'a [u8],
    pub(crate) volume: &'a [f64],
    pub(crate) reference: &'a [Vec3],
    pub(crate) damage: &'a mut [f64],
    pub(crate) damage_time: &'a mut [f64],
    pub(crate) onset_rate: &'a mut [f64],
    pub(crate) normal: &'a mut [Vec3],
    pub(crate) strength: &'a [f64],
    pub(crate) front_time: &'a [f64],
    pub(crate) shielded: &'a [bool],
    pub(crate) eroded: &'a mut [bool],
    pub(crate) flow: &'a mut [FlowState],
}

impl Particles {
    /// Points at rest and unstrained that share `body_volume` \[m³\] and its mass evenly.
    #[must_use]
    pub fn at_rest(positions: &[Vec3], body_volume: f64, density: f64) -> Self {
        let n = positions.len();
        let volume = body_volume / n.max(1) as f64;
        Self {
            density: vec![density],
            kind: vec![0; n],
            id: (0..n as u32).collect(),
            volume: vec![volume; n],
            reference: positions.to_vec(),
            damage: vec![0.0; n],
            damage_time: vec![f64::INFINITY; n],
            onset_rate: vec![0.0; n],
            normal: vec![Vec3::zeros(); n],
            strength: vec![1.0; n],
            front_time: vec![0.0; n],
            shielded: vec![false; n],
            eroded: vec![false; n],
            flow: Vec::new(),
        }
    }

    /// How many there are.
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
        pick(&mut self.kind, order);
        pick(&mut self.volume, order);
        pick(&mut self.reference, order);
        pick(&mut self.damage, order);
        pick(&mut self.damage_time, order);
        pick(&mut self.onset_rate, order);
        pick(&mut self.normal, order);
        pick(&mut self.strength, order);
        pick(&mut self.front_time, order);
        pick(&mut self.shielded, order);
        pick(&mut self.eroded, order);
        if !self.flow.is_empty() {
            pick(&mut self.flow, order);
        }
    }

    /// Takes the points at `olds` to `news`, which are the same places in another order.
    pub(crate) fn shift(&mut self, olds: &[u32], news: &[u32]) {
        carry(&mut self.id, olds, news);
        carry(&mut self.kind, olds, news);
        carry(&mut self.volume, olds, news);
        carry(&mut self.reference, olds, news);
        carry(&mut self.damage, olds, news);
        carry(&mut self.damage_time, olds, news);
        carry(&mut self.onset_rate, olds, news);
        carry(&mut self.normal, olds, news);
        carry(&mut self.strength, olds, news);
        carry(&mut self.front_time, olds, news);
        carry(&mut self.shielded, olds, news);
        carry(&mut self.eroded, olds, news);
        if !self.flow.is_empty() {
            carry(&mut self.flow, olds, news);
        }
    }

    /// Cuts the arrays at `starts` (first point of each piece, then the number of points).
    pub(crate) fn views(&mut self, starts: &[u32]) -> Vec<ParticlesMut<'_>> {
        let mut damage = self.damage.as_mut_slice();
        let mut damage_time = self.damage_time.as_mut_slice();
        let mut onset_rate = self.onset_rate.as_mut_slice();
        let mut normal = self.normal.as_mut_slice();
        let mut eroded = self.eroded.as_mut_slice();
        let mut flow = self.flow.as_mut_slice();
        starts
            .windows(2)
            .map(|pair| {
                let range = pair[0] as usize..pair[1] as usize;
                let n = range.len();
                ParticlesMut {
                    damage: take(&mut damage, n),
                    damage_time: take(&mut damage_time, n),
                    onset_rate: take(&mut onset_rate, n),
                    normal: take(&mut normal, n),
                    eroded: take(&mut eroded, n),
                    flow: if flow.is_empty() { &mut [] } else { take(&mut flow, n) },
                    kind: &self.kind[range.clone()],
                    reference: &self.reference[range.clone()],
                    volume: &self.volume[range.clone()],
                    strength: &self.strength[range.clone()],
                    front_time: &self.front_time[range.clone()],
                    shielded: &self.shielded[range],
                }
            })
            .collect()
    }

    /// Mass of a point \[kg\].
    #[must_use]
    #[inline]
    pub fn mass(&self, p: usize) -> f64 {
        self.density[self.kind[p] as usize] * self.volume[p]
    }
}

fn pick<T: Copy>(array: &mut Vec<T>, order: &[u32]) {
    *array = order.iter().map(|&old| array[old as usize]).collect();
}

fn carry<T: Copy>(array: &mut [T], olds: &[u32], news: &[u32]) {
    let carried: Vec<T> = olds.iter().map(|&old| array[old as usize]).collect();
    news.iter().zip(carried).for_each(|(&new, value)| array[new as usize] = value);
}

fn take<'a, T>(rest: &mut &'a mut [T], n: usize) -> &'a mut [T] {
    let (head, tail) = std::mem::take(rest).split_at_mut(n);
    *rest = tail;
    head
}
