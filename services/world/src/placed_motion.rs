//! Motions of frames, as what a driven body does.

use cullet_geometry::motion::FrameMotion;
use cullet_geometry::{Pose, Quat};
use nalgebra::Translation3;

/// In how many parts the time from one key to the next is divided for what is looked at between.
const PARTS: u32 = 8;

/// A motion of a frame and a body that is fastened to the frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PlacedMotion {
    /// How the frame moves.
    pub motion: FrameMotion,
    /// When the motion begins \[s\]: what it has at its time zero is then.
    pub start: f64,
    /// How much larger its ways are \[1\].
    pub scale: f64,
    /// From where the motion is to the world.
    pub to_world: Pose,
    /// From the frame of the body, whose origin is the centre of mass, to the frame that moves.
    pub from_body: Pose,
}

impl PlacedMotion {
    /// Where the body is at a time \[s\].
    #[must_use]
    pub fn at(&self, time: f64) -> Pose {
        let mut frame = self.motion.at(time - self.start);
        frame.translation.vector *= self.scale;
        let pose = self.to_world * frame * self.from_body;
        let turn = Quat::new_normalize(pose.rotation.into_inner());
        Pose::from_parts(Translation3::from(pose.translation.vector), turn)
    }

    /// The times of the keys of the motion, and seven between each two \[s\].
    #[must_use]
    pub fn sample_times(&self) -> Vec<f64> {
        let keys: Vec<f64> = self.motion.times().iter().map(|key| key + self.start).collect();
        let mut times = Vec::with_capacity(keys.len() * PARTS as usize);
        for pair in keys.windows(2) {
            let part = (pair[1] - pair[0]) / f64::from(PARTS);
            times.extend((0..PARTS).map(|k| pair[0] + part * f64::from(k)));
        }
        times.extend(keys.last());
        // Keys so close that nothing lies between them are one.
        times.dedup();
        times
    }
}
