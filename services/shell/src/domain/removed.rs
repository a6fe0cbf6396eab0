//! Points that leave a soft shell, as those of a piece that has become a rigid body.

use super::state::ShellDomain;
use cullet_simd::Real;

impl<R: Real, const N: usize> ShellDomain<R, N> {
    /// Takes marked points out: they bear nothing from now on, and are joined to none. Cracks that
    /// they have stay in [`ShellDomain::torn_area`].
    pub(crate) fn remove(&mut self, gone: &[bool]) {
        for p in self.live().filter(|&p| gone[p]) {
            self.change(p, |state| {
                (state.dead, state.crumbles) = (true, true);
                state.flow.clear();
                (state.set, state.last) = (None, None);
            });
            self.links.kill(&self.surface, p);
        }
    }

    /// Whether a point has lost none of its links, nor what it bears.
    pub(crate) fn is_whole(&self, point: usize) -> bool {
        let own = self.surface.starts[point] as usize..self.surface.starts[point + 1] as usize;
        self.is_on(point) && !self.links.dead[point] && !self.links.severed[own].contains(&true)
    }
}
