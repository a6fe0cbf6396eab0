//! Who takes part in a replacement beside the broken body: what hit it, and what held it.

use crate::cluster::{Part, Parts};
use crate::exchange::Exchange;
use crate::impact::Hit;
use crate::impulse_exchange::Striker;
use crate::motion::Motion;
use crate::state::WorldState;
use crate::support::Reaction;
use cullet_geometry::Vec3;

/// Who hit the body, one entry a partner.
pub(crate) fn find_strikers(world: &WorldState, body: u32, hits: &[Hit]) -> Vec<Striker> {
    let mut strikers: Vec<(u32, Striker)> = Vec::new();
    let whole: f64 = hits.iter().map(|hit| hit.impact.impulse).sum();
    for hit in hits {
        let weight = if whole > 0.0 { hit.impact.impulse / whole } else { 1.0 / hits.len() as f64 };
        let striker = striker_of(world, body, hit, weight);
        match strikers.iter_mut().find(|(other, _)| *other == hit.other.0) {
            Some((_, known)) => known.merge(&striker),
            None => strikers.push((hit.other.0, striker)),
        }
    }
    strikers.into_iter().map(|(_, striker)| striker).collect()
}

/// The strikers and supports that move, as they move now.
pub(crate) fn moving_parts(world: &WorldState, strikers: &[Striker]) -> Parts {
    let part = |&id: &u32| Some((id, Part::new(world.bodies.get(&id)?, &world.rigid.motion(id)?)));
    strikers.iter().flat_map(|striker| &striker.ids).filter_map(part).collect()
}

/// A support as more that met the body: itself, with the share that it kept, and the ground
/// behind it with the rest.
pub(crate) fn supporting_strikers(
    world: &WorldState,
    reaction: &Reaction,
    motion: &Motion,
) -> Vec<Striker> {
    let support = &reaction.support;
    let mut ids = Vec::new();
    if support.kept > 0.0 {
        add_living_descendants(world, support.other.0, &mut ids);
    }
    let push = motion.to_world(&support.held.normal) * reaction.impulse;
    let holder = |ids: Vec<u32>, share: f64| Striker {
        mine: support.exchanged.scaled(share),
        theirs: if ids.is_empty() {
            Exchange::zero()
        } else {
            support.exchanged_other.scaled(share)
        },
        ids,
        weight: 0.0,
        point: (motion.pose * nalgebra::Point3::from(support.held.point)).coords,
        lever: support.lever,
        reaction: Some(push * share),
        driven: None,
    };
    if ids.is_empty() {
        return vec![holder(ids, 1.0)];
    }
    let own = holder(ids, support.kept);
    let ground = (support.kept < 1.0).then(|| holder(Vec::new(), 1.0 - support.kept));
    std::iter::once(own).chain(ground).collect()
}

fn striker_of(world: &WorldState, body: u32, hit: &Hit, weight: f64) -> Striker {
    let pending = world.replaced.pending.get(&(hit.episode, body));
    let (mine, theirs) =
        pending.map_or((hit.exchanged, hit.exchanged_other), |d| (d.mine, d.theirs));
    let first = pending.map_or_else(|| vec![hit.other.0], |d| d.others.clone());
    let mut ids = Vec::new();
    first.iter().for_each(|&id| add_living_descendants(world, id, &mut ids));
    let point = match (ids.as_slice(), pending) {
        (&[id], None) if id == hit.other.0 => point_now(world, id, &hit.other_point),
        _ => None,
    };
    let point = point.unwrap_or(hit.point);
    let driven = hit.driven_at.map(|velocity| (hit.other.0, velocity));
    Striker { ids, mine, theirs, weight, point, lever: hit.lever, reaction: None, driven }
}

/// What is left of the energy that each hit's contact took \[J\].
pub(crate) fn remaining_budgets(world: &WorldState, body: u32, hits: &[Hit]) -> Vec<f64> {
    let left = |hit: &Hit| {
        let pending = world.replaced.pending.get(&(hit.episode, body));
        pending.map_or(hit.dissipated, |pending| pending.energy_budget)
    };
    hits.iter().map(left).collect()
}

/// A point of a body's frame where it is now \[m\].
fn point_now(world: &WorldState, id: u32, local: &Vec3) -> Option<Vec3> {
    world.rigid.motion(id).map(|m| (m.pose * nalgebra::Point3::from(*local)).coords)
}

/// The moving bodies that a body has become by now.
fn add_living_descendants(world: &WorldState, id: u32, into: &mut Vec<u32>) {
    match world.bodies.get(&id) {
        Some(body) if !body.immovable() => into.push(id),
        Some(_) => {}
        None => {
            for &child in world.replaced.children.get(&id).into_iter().flatten() {
                add_living_descendants(world, child, into);
            }
        }
    }
}

impl Striker {
    /// A second hit by the same partner.
    fn merge(&mut self, other: &Self) {
        let weight = self.weight + other.weight;
        self.point = (self.point * self.weight + other.point * other.weight) / weight;
        self.lever = (self.lever * self.weight + other.lever * other.weight) / weight;
        self.weight = weight;
        self.mine.add(&other.mine);
        self.theirs.add(&other.theirs);
    }
}
