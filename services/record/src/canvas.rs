//! When viewers get a new drawing of an object, and what is drawn beside the objects.

use super::display::{self, Live};
use super::object::scene_topic;
use super::{RecordError, Recorder, STATS};
use cullet_proto::recording::RunStats;
use std::collections::BTreeMap;

/// Least time between two drawings of one object \[s\]: 15 a second, less a rounding error.
const DRAW_INTERVAL: f64 = 1.0 / 15.0 - 1e-9;
/// Most share that may be saved up \[s\], so that a quiet start does not pay for one long burst.
const DRAW_SAVINGS: f64 = 0.5;

/// Most bytes that may be saved up \[bytes\].
fn savings(rate: f64) -> f64 {
    rate * DRAW_SAVINGS
}

impl Recorder {
    /// Draws the objects that changed, and those that moved if they are due and can be afforded.
    pub(super) fn draw(&mut self, all: bool) -> Result<(), RecordError> {
        let earned = (self.time - self.drawing.at).max(0.0) * self.drawing.rate;
        let savings = savings(self.drawing.rate);
        self.drawing.left = (self.drawing.left + earned).min(savings);
        self.drawing.at = self.time;
        let mut due: Vec<(f64, String)> = Vec::new();
        for (name, object) in &self.objects {
            let last = object.drawn_at.unwrap_or(f64::NEG_INFINITY);
            let rested = self.time - last >= DRAW_INTERVAL;
            let placed = object
                .parts
                .iter()
                .all(|id| self.bodies.get(id).is_some_and(|live| live.row.is_some()));
            let stirred = object.changed && placed || object.moved && (rested || all);
            if stirred {
                due.push((last, name.clone()));
            }
        }
        // Who waited longest goes first: a small budget is shared, not eaten by the first names.
        due.sort_by(|a, b| a.0.total_cmp(&b.0).then_with(|| a.1.cmp(&b.1)));
        let drew = !due.is_empty();
        for (_, name) in due {
            self.draw_object(&name, all)?;
        }
        if all {
            self.draw_waiting_sheets()?;
        }
        if drew && (all || self.time - self.drawing.overview_at >= DRAW_INTERVAL) {
            self.drawing.overview_at = self.time;
            self.draw_overview()?;
        }
        Ok(())
    }

    fn draw_object(&mut self, name: &str, all: bool) -> Result<(), RecordError> {
        let stamp = self.stamp();
        let (time, left) = (self.time, self.drawing.left);
        let Some(object) = self.objects.get_mut(name) else {
            return Ok(());
        };
        if !object.changed && !all && left <= 0.0 {
            return Ok(());
        }
        (object.moved, object.changed) = (false, false);
        object.drawn_at = Some(time);
        if !self.drawing.objects {
            return Ok(());
        }
        let parts: Vec<&Live> = object.parts.iter().filter_map(|id| self.bodies.get(id)).collect();
        let update = display::scene_update(name, stamp.log, &parts);
        let bytes = self.sink.known(&scene_topic(name), stamp, &update)?;
        self.drawing.left -= bytes as f64;
        Ok(())
    }

    fn draw_overview(&mut self) -> Result<(), RecordError> {
        let stamp = self.stamp();
        let moving = || self.bodies.values().filter(|live| !live.body.fixed);
        let cloud = display::point_cloud(stamp.log, moving());
        let energy: f64 = moving()
            .filter_map(|live| live.row.map(|r| 0.5 * live.body.mass * r.velocity.norm_squared()))
            .sum();
        let so_far = self.tally.summary(&self.meta, &BTreeMap::new());
        let stats = RunStats {
            step: self.step,
            time: self.time,
            bodies: self.bodies.len() as u64,
            fragments: so_far.fragments,
            fractures: so_far.fractures,
            jobs_open: self.tally.jobs_open(),
            translational_energy: energy,
        };
        self.sink.known("/fragments", stamp, &cloud)?;
        self.sink.own(STATS, stamp, &stats).map(|_| ())
    }
}
