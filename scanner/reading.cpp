#include "scanner/reading.hpp"

#include "assemblies/parameter_value.hpp"
#include "cip/services.hpp"
#include "cip/wire.hpp"

namespace servobus::scanner {

cip::Path path_to(const drive::Parameter& row) {
    return cip::Path::to(row.cip.class_id, row.cip.instance, row.cip.attribute);
}

cip::Request read_request(const drive::Parameter& row) {
    return {cip::service::get_attribute_single, path_to(row), {}};
}

cip::Request write_request(const drive::Parameter& row, const drive::Value& value) {
    cip::Request request{cip::service::set_attribute_single, path_to(row), {}};
    cip::Writer writer(request.data);
    assemblies::write_value(writer, row, value);
    return request;
}

boost::system::result<ReadOutcome> read_outcome(const drive::Parameter& row, const cip::Response& response) {
    ReadOutcome outcome;
    outcome.status = response.status;
    if (!response.status.ok()) return outcome;
    const cip::ByteView data(response.data);
    const auto size = assemblies::value_size(row, data);
    if (!size || *size > data.size()) return make_error_code(Error::missing_data);
    const auto value = assemblies::read_value(row, data.first(*size));
    if (!value) return make_error_code(Error::missing_data);
    outcome.value = *value;
    outcome.surplus = data.size() - *size;
    // A STRING of odd length may be padded to whole words (R-TYP-5).
    if (row.is_text() && outcome.surplus == 1 && *size % 2 != 0) outcome.surplus = 0;
    return outcome;
}

}  // namespace servobus::scanner
