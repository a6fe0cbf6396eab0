//! Steps of a sheet that others drive: loads on its points, and velocities that they are given.

use super::SheetRun;
use cullet_geometry::Vec3;

impl SheetRun {
    /// Chooses the points whose bonds may not break, for as long as the step of the world lasts.
    pub(crate) fn guard_points(&mut self, guarded: Vec<bool>) {
        self.grips.guarded = guarded;
        self.read_bonds(false);
    }

    /// Forces on the points in the next steps \[N\], beside those that the sheet finds: none yet.
    pub(crate) fn loads(&mut self) -> &mut [Vec3] {
        self.is_pushed = true;
        self.touch.fill(Vec3::zeros());
        &mut self.touch
    }

    /// Takes one step, with places and velocities at its end, where they can be changed.
    pub(crate) fn advance_whole(&mut self) {
        let half = 0.5 * self.prepared.step();
        if self.substep > 0 {
            self.kernel.drift(&mut self.state.places, &self.state.velocities, half);
        }
        if !self.advance() {
            // The kernel has gone on to the middle of the next step.
            let rows = self.state.places.iter_mut().zip(&self.state.velocities);
            rows.for_each(|(x, v)| *x -= v * half);
        }
    }
}
