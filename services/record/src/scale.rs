//! Numbers as colours, from the least to the greatest.

use cullet_proto::specimen::Frame;

/// Colours from the least value to the greatest.
const SCALE: [[f32; 3]; 5] = [
    [53.0, 68.0, 110.0],
    [60.0, 132.0, 160.0],
    [150.0, 190.0, 140.0],
    [240.0, 190.0, 80.0],
    [214.0, 70.0, 50.0],
];

/// Least and greatest value of all frames.
#[must_use]
pub fn range(frames: &[Frame]) -> (f32, f32) {
    let values = frames.iter().flat_map(|frame| frame.points.iter().map(|point| point[3]));
    let none = (f32::INFINITY, f32::NEG_INFINITY);
    values.filter(|v| v.is_finite()).fold(none, |(low, high), v| (low.min(v), high.max(v)))
}

/// The colour of a value.
#[must_use]
pub fn colour(value: f32, (low, high): (f32, f32)) -> [u8; 3] {
    let share = if high > low { ((value - low) / (high - low)).clamp(0.0, 1.0) } else { 0.0 };
    let place = if share.is_finite() { share * (SCALE.len() - 1) as f32 } else { 0.0 };
    let k = (place as usize).min(SCALE.len() - 2);
    let part = place - k as f32;
    [0, 1, 2].map(|c| (SCALE[k][c] + (SCALE[k + 1][c] - SCALE[k][c]) * part).round() as u8)
}
