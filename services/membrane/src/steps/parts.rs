//! The pieces of a sheet in motion: which there are, and which are at rest.

use super::SheetRun;
use crate::crossings::{crossed_points, live_pairs};
use crate::grips::FREE;
use crate::pieces::components;
use crate::state::SheetState;
use cullet_continuum::TouchedPoints;
use cullet_continuum::air;
use cullet_continuum::pieces::{frozen_points, renumber};
use cullet_continuum::rest::RestCheck;
use cullet_geometry::Vec3;
use std::sync::Arc;

impl SheetRun {
    /// Finds the pieces after bonds have broken, and drops ties between them (F84m).
    pub(crate) fn part(&mut self) {
        if std::mem::take(&mut self.breaks) == 0 {
            return;
        }
        let prepared = Arc::clone(&self.prepared);
        let found = components(&prepared.bonds, &self.state.damage, prepared.sheet().spacing);
        let ends = &prepared.bonds.ends;
        let tie = |i: usize, b: usize| found[i] != found[ends[b] as usize];
        let mut parted: Vec<usize> = Vec::new();
        let mut ties = Vec::new();
        for i in 0..found.len() {
            let before = ties.len();
            let live = |b: &usize| self.state.damage[*b] < 1.0 && tie(i, *b);
            ties.extend(prepared.bonds.of(i).filter(live));
            if ties.len() > before {
                parted.push(i);
            }
        }
        if !ties.is_empty() {
            let stored = |run: &Self| {
                run.energy_input().stretching(&run.state) + run.energy_input().bending(&run.state)
            };
            let before = stored(self);
            ties.iter().for_each(|&b| self.state.damage[b] = 1.0);
            self.read_bonds(false);
            parted.iter().for_each(|&i| self.refit(i));
            self.books.sums.broken += before - stored(self);
            self.books.sums.breaks += ties.len() as u32;
            self.watch.drop_ties(&ties);
        }
        let SheetState { labels, pieces, step, .. } = &mut self.state;
        renumber(&found, &prepared.points.areas, labels, pieces, *step);
    }

    /// Finds which pieces are at rest, and stops those that have been for long.
    pub(super) fn rest(&mut self) {
        let prepared = Arc::clone(&self.prepared);
        let sheet = prepared.sheet();
        // What still spreads may move it again.
        if air::blows(&sheet.air) || !prepared.diffusion.is_empty() {
            return;
        }
        let held: Vec<bool> = self.grips.holders.iter().map(|&holder| holder != FREE).collect();
        let pressed = self.lips.pressed(&self.state.places);
        let check = RestCheck {
            labels: &self.state.labels,
            places: &self.state.places,
            velocities: &self.state.velocities,
            held: &held,
            touched: &self.touched,
            pressed: &pressed,
            proxies: &self.proxies,
            spacing: sheet.spacing,
            world_step: prepared.setup.world_step,
        };
        if check.count(&mut self.state.pieces) {
            self.keep_crossed_awake();
        }
        self.freeze();
        for i in 0..self.frozen.len() {
            let v = self.state.velocities[i];
            if self.frozen[i] && v != Vec3::zeros() {
                // What stops a piece is what it rests on.
                let lost = v * self.masses[i][1];
                self.books.sums.impulse -= lost;
                self.books.sums.exchanged += lost.norm();
                self.books.sums.damped += 0.5 * lost.dot(&v);
                self.state.velocities[i] = Vec3::zeros();
            }
        }
    }

    /// Pieces that go through themselves or others are not frozen: they may come free (F95m).
    pub(crate) fn keep_crossed_awake(&mut self) {
        let triangles = self.whole_triangles(&live_pairs(&self.prepared, &self.state.damage));
        let crossed = crossed_points(&triangles, &self.state.places);
        let mut labels: Vec<u32> = crossed.iter().map(|&i| self.state.labels[i as usize]).collect();
        labels.sort_unstable();
        labels.dedup();
        for piece in &mut self.state.pieces {
            if labels.binary_search(&piece.number).is_ok() {
                piece.still = 0;
            }
        }
    }

    /// Triangles that nothing tears, of pieces that are here.
    pub(crate) fn whole_triangles(&self, alive: &[bool]) -> Vec<[u32; 3]> {
        let mut triangles = self.prepared.triangles.whole(alive);
        triangles.retain(|corners| !self.gone[corners[0] as usize]);
        triangles
    }

    /// One step where all pieces are gone: only rigid bodies move.
    pub(super) fn move_bodies_alone(&mut self) -> bool {
        let dt = self.prepared.step();
        let nothing = TouchedPoints {
            places: &[],
            velocities: &[],
            masses: &[],
            frozen: &[],
            distance: self.prepared.contact(),
            dt,
        };
        for proxy in &mut self.proxies {
            proxy.drift(0.5 * dt);
            proxy.touch(&nothing, self.prepared.setup.gravity, &mut []);
            proxy.drift(0.5 * dt);
        }
        self.substep += 1;
        self.books.steps += 1;
        let ended = self.substep == self.prepared.substeps;
        if ended {
            self.end();
        }
        ended
    }

    /// Marks the points of pieces at rest.
    pub(super) fn freeze(&mut self) {
        let (state, world_step) = (&self.state, self.prepared.setup.world_step);
        self.frozen = frozen_points(&state.labels, &state.pieces, world_step);
    }
}
