//! Pieces of a soft shell at rest: which they are, and what stops with them.

use super::super::held::FREE;
use super::SoftShellRun;
use cullet_continuum::air;
use cullet_continuum::pieces::patience;
use cullet_continuum::rest::RestCheck;
use cullet_geometry::Vec3;

/// The elements of a list at some places.
fn picked<T: Copy>(all: &[T], at: &[usize]) -> Vec<T> {
    at.iter().map(|&n| all[n]).collect()
}

impl<const N: usize> SoftShellRun<N> {
    /// The piece of each control point.
    fn node_labels(&self) -> Vec<u32> {
        let domain = &self.state.domain;
        let mut labels = vec![0; domain.mass.len()];
        for p in domain.live().filter(|&p| !domain.state(p).dead) {
            for &n in domain.functions(p).0 {
                labels[n as usize] = self.state.labels[p];
            }
        }
        labels
    }

    /// Finds which pieces are at rest, and stops those that have been for long.
    pub(super) fn rest(&mut self) {
        if !air::blows(&self.prepared.body.air) {
            self.count_rest();
        }
        self.freeze();
        self.stop();
    }

    /// Counts for how long pieces have been at rest.
    fn count_rest(&mut self) {
        let labels = self.node_labels();
        self.touched.resize(labels.len(), false);
        let domain = &self.state.domain;
        let (_, places) = domain.node_places();
        // What moves nothing is of no piece.
        let moves = domain.moves();
        let here: Vec<usize> = (0..moves.len()).filter(|&n| moves[n]).collect();
        let pressed = self.pressed(&here);
        let held = |&n: &usize| self.holders[domain.origin[n] as usize] != FREE;
        let check = RestCheck {
            labels: &picked(&labels, &here),
            places: &picked(&places, &here),
            velocities: &picked(&domain.velocity, &here),
            held: &here.iter().map(held).collect::<Vec<_>>(),
            touched: &picked(&self.touched, &here),
            pressed: &pressed,
            proxies: &self.proxies,
            spacing: self.prepared.body.spacing,
            world_step: self.prepared.setup.world_step,
        };
        check.count(&mut self.state.pieces);
        self.touched.fill(false);
    }

    /// Pairs of those control points, by their places in the list, whose walls press on each other.
    fn pressed(&self, here: &[usize]) -> Vec<[u32; 2]> {
        let domain = &self.state.domain;
        let end = |p: u32| {
            let (nodes, _) = domain.functions(p as usize);
            nodes.iter().find_map(|&n| here.binary_search(&(n as usize)).ok()).map(|at| at as u32)
        };
        let pairs = self.meeting.pressed(domain).into_iter();
        pairs.filter_map(|[p, q]| Some([end(p)?, end(q)?])).collect()
    }

    /// Stops what is frozen.
    fn stop(&mut self) {
        let domain = &mut self.state.domain;
        for (n, v) in domain.velocity.iter_mut().enumerate() {
            if self.frozen[n] && *v != Vec3::zeros() {
                // What stops a piece is what it rests on.
                let lost = *v * domain.mass[n];
                self.books.give(&-lost);
                self.books.damped += 0.5 * lost.dot(v);
                *v = Vec3::zeros();
            }
        }
    }

    /// Marks what belongs to pieces at rest.
    pub(super) fn freeze(&mut self) {
        let patience = patience(self.prepared.setup.world_step);
        let most = self.state.pieces.iter().map(|piece| piece.number).max().unwrap_or(0);
        self.still = vec![false; most as usize + 1];
        for piece in &self.state.pieces {
            self.still[piece.number as usize] = piece.still >= patience;
        }
        let labels = self.node_labels();
        let moves = self.state.domain.moves();
        let rests = |(&label, moves): (&u32, bool)| self.still[label as usize] || !moves;
        self.frozen = labels.iter().zip(moves).map(rests).collect();
        self.all_frozen = self.frozen.iter().all(|&frozen| frozen);
    }
}
