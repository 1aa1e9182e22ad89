//! The table `cameras`.

use super::named_documents::named_documents;

named_documents!("cameras");
