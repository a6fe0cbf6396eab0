//! Contact between the sides of a crack, and between bodies that lie on the grid together: copies
//! of a node may part and slide, not pass through each other (F18). Sides of cracks rub, by
//! Coulomb's law: without it crumbs under a contact slide out and carry nothing.

use super::grid::Nodes;
use super::stencil::{packed, vector};
use cullet_geometry::Vec3;
use cullet_simd::Incidence;

/// Least distance between the centres of two sides, in cells, that tells where they lie.
const LEAST: f64 = 1e-9;

/// Each copy meets so many of the heaviest at its node, not the crumbs between them.
const HEAVY: usize = 3;

/// Two copies of a node and the unit normal out of the first, into the second.
#[derive(Clone, Copy, Debug, PartialEq)]
struct NodePair {
    first: u32,
    second: u32,
    normal: Vec3,
    /// Distance between the two before anything moved \[m\]: none between the sides of a crack.
    apart: f64,
    /// Whether they rub.
    rough: bool,
    /// Velocity of the second beside the first at the end of the last step \[m/s\].
    before: Vec3,
    /// On the second in this step, against the first \[N·s\].
    impulse: Vec3,
}

/// How two bodies lie at a node that both reach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Facing {
    /// The node that its copies were made of.
    pub node: u32,
    /// The bodies, the lesser number first.
    pub bodies: [u8; 2],
    /// Unit normal out of the first, into the second.
    pub normal: Vec3,
    /// Distance between their surfaces along it \[m\].
    pub apart: f64,
}

/// The pairs of copies of a body's nodes.
#[derive(Clone, Debug, Default)]
pub(super) struct NodeContacts {
    /// How bodies lie at the nodes that several reach, by node and bodies ascending.
    pub(super) facings: Vec<Facing>,
    /// Coulomb's coefficient between the sides of a crack \[1\].
    pub(super) friction: f64,
    /// Nodes that were parted before anything broke, ascending: what was sawn does not rub.
    sawn: Vec<u32>,
    pairs: Vec<NodePair>,
    shoves: Vec<Shove>,
}

/// What one copy of a node gave another in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Shove {
    /// Both.
    pub(crate) nodes: [u32; 2],
    /// On the second; the first has as much against it \[N·s\].
    pub(crate) impulse: Vec3,
}

impl NodeContacts {
    /// Takes the copies of nodes that there are for the sides of cuts.
    pub(super) fn saw(&mut self, nodes: &Nodes) {
        let places = Incidence::new(nodes.origin.iter().copied(), nodes.len());
        let parted = (0..nodes.len() as u32).filter(|&node| places.of(node as usize).len() > 1);
        self.sawn = parted.collect();
    }

    /// Finds the pairs of copies, and the normals between them: from where their points lie, or for
    /// two bodies from how they face each other. What passed in the last step stays known.
    pub(super) fn find(&mut self, nodes: &Nodes, spacing: &Vec3) {
        let places = Incidence::new(nodes.origin.iter().copied(), nodes.len());
        let (mut pairs, mut copies) = (Vec::new(), Vec::new());
        for node in 0..nodes.len() {
            if places.of(node).len() < 2 {
                continue;
            }
            copies.clear();
            copies.extend_from_slice(places.of(node));
            let rough = self.sawn.binary_search(&(node as u32)).is_err();
            let mass = |n: &u32| nodes.mass[*n as usize];
            copies.sort_by(|a, b| mass(b).total_cmp(&mass(a)));
            for (i, &first) in copies.iter().enumerate().take(HEAVY) {
                for &second in &copies[i + 1..] {
                    if let Some(facing) = facing(nodes, &self.facings, [first, second]) {
                        pairs.extend(facing);
                        continue;
                    }
                    let across =
                        nodes.points_offset[second as usize] - nodes.points_offset[first as usize];
                    if across.norm() > LEAST {
                        // The normal of a plane, given in cells, in metres.
                        let normal = across.component_div(spacing).normalize();
                        pairs.push(NodePair { rough, ..NodePair::new([first, second], normal) });
                    }
                }
            }
        }
        self.pairs = pairs;
        self.restart(nodes);
    }

    /// Takes the velocities that there are for those at the end of a step.
    pub(super) fn restart(&mut self, nodes: &Nodes) {
        for pair in &mut self.pairs {
            pair.before = pair.rate(nodes);
        }
    }

    /// Stops the copies that would overlap at the end of the step, to the velocity that closes what
    /// gap there is, and what slides meanwhile by as much as friction bears. Momentum is kept, pair
    /// by pair. Returns the energy that this takes \[J\].
    ///
    /// An impulse J between two does the work J·(w₀ + w₁)/2 on them, w being the second's velocity
    /// beside the first before and after the whole step, whatever else pushes them in that: what
    /// presses and does not move takes nothing.
    pub(super) fn resolve(&mut self, nodes: &mut Nodes, step: f64) -> f64 {
        self.shoves.clear();
        for pair in &mut self.pairs {
            let (a, b) = (pair.first as usize, pair.second as usize);
            let opened = vector(nodes.displacement[b] - nodes.displacement[a]).dot(&pair.normal);
            let gap = opened + pair.apart;
            let rate = pair.rate(nodes);
            let along = rate.dot(&pair.normal);
            let overlap = -(gap.max(0.0) + step * along);
            pair.impulse = Vec3::zeros();
            if overlap <= 0.0 {
                continue;
            }
            let (first, second) = (nodes.mass[a], nodes.mass[b]);
            let reduced = first * second / (first + second);
            let press = overlap / step * reduced;
            pair.impulse = pair.normal * press;
            if pair.rough {
                let slip = rate - pair.normal * along;
                let most = self.friction * press / (reduced * slip.norm()).max(f64::MIN_POSITIVE);
                pair.impulse -= slip * (reduced * most.min(1.0));
            }
            nodes.velocity[a] -= packed(pair.impulse / first);
            nodes.velocity[b] += packed(pair.impulse / second);
            self.shoves.push(Shove { nodes: [pair.first, pair.second], impulse: pair.impulse });
        }
        let mut taken = 0.0;
        for pair in &mut self.pairs {
            let after = pair.rate(nodes);
            taken -= 0.5 * pair.impulse.dot(&(pair.before + after));
            pair.before = after;
        }
        taken
    }

    /// What passed between copies in the last step.
    pub(super) fn shoves(&self) -> &[Shove] {
        &self.shoves
    }
}

impl NodePair {
    /// Sides of a cut.
    fn new([first, second]: [u32; 2], normal: Vec3) -> Self {
        let (before, impulse) = (Vec3::zeros(), Vec3::zeros());
        Self { first, second, normal, apart: 0.0, rough: false, before, impulse }
    }

    /// Velocity of the second beside the first \[m/s\].
    fn rate(&self, nodes: &Nodes) -> Vec3 {
        vector(nodes.velocity[self.second as usize] - nodes.velocity[self.first as usize])
    }
}

/// The pair of two bodies' copies, if they are of two: none where they do not face each other.
fn facing(
    nodes: &Nodes,
    facings: &[Facing],
    [first, second]: [u32; 2],
) -> Option<Option<NodePair>> {
    let [a, b] = [first, second].map(|n| nodes.body[n as usize]);
    if a == b {
        return None;
    }
    let bodies = [a.min(b), a.max(b)];
    let key = (nodes.origin[first as usize], bodies);
    let found = facings.binary_search_by_key(&key, |facing| (facing.node, facing.bodies)).ok();
    let [first, second] = if a < b { [first, second] } else { [second, first] };
    let pair = |at: usize| {
        let Facing { normal, apart, .. } = facings[at];
        NodePair { apart, ..NodePair::new([first, second], normal) }
    };
    Some(found.map(pair))
}
