//! The table `workcells`.

use super::named_documents::named_documents;

named_documents!("workcells");
