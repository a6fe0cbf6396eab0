//! What is found in a file.

use mcap::records::{AttachmentHeader, Channel, MessageHeader, Metadata, SchemaHeader};
use std::collections::BTreeMap;
use std::sync::Arc;

/// One thing found in a file, in file order.
pub(super) enum Found {
    Schema(SchemaHeader, Vec<u8>),
    Channel(Channel),
    /// With its topic, if its type is one of ours.
    Message(MessageHeader, Vec<u8>, Option<Arc<str>>),
    Attachment(AttachmentHeader, Vec<u8>),
    Metadata(Metadata),
    ChunkEnd,
    /// A part that is damaged, here or in the file from which this one was recovered.
    Hole,
    /// How many messages of each topic of ours are gone that no later one of it misses, for a file
    /// whose end counts them.
    Gone(BTreeMap<String, u64>),
}
