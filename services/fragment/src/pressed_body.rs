//! What a body of points has to say and to bear for rigid ones to press on it.

use cullet_geometry::{Mat3, Vec3};

/// Where a solve is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressClock {
    /// Since its beginning \[s\].
    pub time: f64,
    /// Length of the next step \[s\].
    pub step: f64,
    /// Steps so far.
    pub steps: u64,
}

/// A body of points that are numbered from 0.
pub trait PressedBody {
    /// Where its solve is.
    fn clock(&self) -> PressClock;

    /// Where the point of that number is \[m\], and the gradient of the displacement there \[1\].
    fn point_now(&self, id: u32) -> (Vec3, Mat3);

    /// How fast the point of that number moves \[m/s\]; none of one that bears nothing any more.
    fn speed_now(&self, id: u32) -> Option<Vec3>;

    /// Gives the place beside that point which goes with its motion and its gradient, `offset`
    /// \[m\] away before the hit, an impulse \[N·s\].
    fn kick(&mut self, id: u32, offset: &Vec3, impulse: &Vec3);
}
