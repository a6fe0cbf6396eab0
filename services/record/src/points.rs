//! A recording of points alone: `foxglove.PointCloud` on `/points`, a frame a message.

use super::RecordError;
use super::display::{WORLD, timestamp};
use super::scale::{colour, range};
use super::sink::{Sink, Stamp};
use cullet_proto::specimen::Frame;
use foxglove::bytes::{BufMut, Bytes, BytesMut};
use foxglove::messages::packed_element_field::NumericType;
use foxglove::messages::{PackedElementField, PointCloud, Pose, Quaternion, Vector3};
use std::collections::BTreeMap;
use std::path::Path;

/// The metadata record that tells such a recording from that of a run.
pub(super) const SPECIMEN: &str = "cullet.specimen";

/// Topic of the points.
pub const POINTS: &str = "/points";

/// Writes frames into an MCAP file; log time is simulated time. Colours run from the least to the
/// greatest value of all frames.
///
/// # Errors
/// The file cannot be written.
pub fn record(path: &Path, name: &str, frames: &[Frame]) -> Result<(), RecordError> {
    let mut sink = Sink::create(path, None)?;
    let about = BTreeMap::from([("specimen".to_owned(), name.to_owned())]);
    sink.metadata(SPECIMEN, &about)?;
    let span = range(frames);
    for frame in frames {
        let log = (frame.time * 1e9).round().max(0.0) as u64;
        sink.known(POINTS, Stamp { log, publish: log }, &cloud(log, frame, span))?;
    }
    sink.finish()
}

fn cloud(log_time: u64, frame: &Frame, span: (f32, f32)) -> PointCloud {
    let mut data = BytesMut::new();
    for point in &frame.points {
        point.iter().for_each(|&number| data.put_f32_le(number));
        let [red, green, blue] = colour(point[3], span);
        data.put_slice(&[red, green, blue, 255]);
    }
    let names = ["x", "y", "z", "value", "red", "green", "blue", "alpha"];
    let field = |(index, name): (usize, &str)| PackedElementField {
        name: name.to_owned(),
        offset: if index < 4 { 4 * index } else { 12 + index } as u32,
        r#type: if index < 4 { NumericType::Float32 } else { NumericType::Uint8 } as i32,
    };
    PointCloud {
        timestamp: Some(timestamp(log_time)),
        frame_id: WORLD.to_owned(),
        pose: Some(Pose {
            position: Some(Vector3::default()),
            orientation: Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }),
        }),
        point_stride: 20,
        fields: names.into_iter().enumerate().map(field).collect(),
        data: Bytes::from(data),
    }
}
