#include "server/nightly/night_store.hpp"

#include "server/store/store_access.hpp"

namespace subpixel::server {
namespace {

using nlohmann::json;

constexpr std::string_view kNightColumns =
    "SELECT id, name, status, reason, started_utc, finished_utc, build, config, baseline, baseline_night, commit_id, "
    "facts FROM nights ";

NightRecord read_night(Statement& row) {
  NightRecord night;
  night.id = row.integer();
  night.name = row.text();
  night.status = night_status_from_text(row.text());
  night.reason = row.text();
  night.started_utc = row.text();
  night.finished_utc = row.text();
  night.build = row.text();
  night.config = json::parse(row.text());
  night.baseline = row.optional_text();
  if (const std::optional<std::string> number = row.optional_text()) night.baseline_night = std::stoll(*number);
  night.commit = row.text();
  night.facts = json::parse(row.text());
  return night;
}

void read_captures(const Connection& connection, NightRecord& night) {
  Statement select(connection,
                   "SELECT name, source, hash, problem, head FROM night_captures WHERE night = ? ORDER BY ordinal");
  select.bind(night.id);
  while (select.step()) {
    NightCapture capture;
    capture.name = select.text();
    capture.source = select.text();
    capture.hash = select.text();
    capture.problem = select.text();
    if (const std::optional<std::string> head = select.optional_text()) {
      capture.head = replay::results_head_from_json(json::parse(*head));
    }
    night.captures.push_back(std::move(capture));
  }
}

constexpr std::string_view kCellColumns = "SELECT id, capture, technique, status, gates, time FROM night_cells ";

NightCell read_cell(Statement& row) {
  NightCell cell;
  cell.id = row.integer();
  cell.capture = static_cast<std::uint32_t>(row.integer());
  cell.technique = row.text();
  cell.status = cell_status_from_text(row.text());
  cell.gates = gates_from_json(json::parse(row.text()));
  cell.time = cell_time_from_json(json::parse(row.text()));
  return cell;
}

void read_cells(const Connection& connection, NightRecord& night) {
  Statement select(connection, std::string(kCellColumns) + "WHERE night = ? ORDER BY id");
  select.bind(night.id);
  while (select.step()) night.cells.push_back(read_cell(select));
}

void read_frames(const Connection& connection, NightCell& cell) {
  Statement select(connection,
                   "SELECT id, document, (SELECT blob FROM night_images i WHERE i.frame = night_frames.id AND role = "
                   "'difference') FROM night_frames WHERE cell = ? ORDER BY frame");
  select.bind(cell.id);
  while (select.step()) {
    NightFrame frame;
    frame.id = select.integer();
    frame.result = replay::frame_result_from_json(json::parse(select.text()));
    frame.difference = select.text();
    cell.frames.push_back(std::move(frame));
  }
}

void insert_image(const Connection& connection, std::int64_t frame, const std::string& role, const std::string& hash) {
  Statement(connection,
            "INSERT INTO night_images (frame, role, blob) VALUES (?, ?, ?) ON CONFLICT DO UPDATE SET blob = "
            "excluded.blob")
      .bind(frame)
      .bind(role)
      .bind(hash)
      .run();
}

// Returns the blobs outside that then nothing names.
std::vector<std::string> drop_rows(const Connection& connection, std::string_view name, std::uint32_t keep) {
  Transaction transaction(connection);
  Statement old(connection,
                "WITH kept AS (SELECT id, baseline_night FROM nights WHERE name = ?1 ORDER BY id DESC LIMIT ?2) "
                "SELECT id FROM nights WHERE name = ?1 AND id NOT IN (SELECT id FROM kept) "
                "AND id NOT IN (SELECT night FROM baselines) "
                "AND id NOT IN (SELECT baseline_night FROM kept WHERE baseline_night IS NOT NULL)");
  std::vector<std::string> outside;
  for (const std::string& night : texts(old.bind(name).bind(std::int64_t{keep}))) {
    Statement named(
        connection,
        "SELECT DISTINCT i.blob FROM night_cells c JOIN night_frames f ON f.cell = c.id JOIN night_images i "
        "ON i.frame = f.id WHERE c.night = ?");
    const std::vector<std::string> blobs = texts(named.bind(night));
    Statement(connection, "DELETE FROM nights WHERE id = ?").bind(night).run();
    for (std::string& hash : delete_unnamed_blobs(connection, blobs)) outside.push_back(std::move(hash));
  }
  transaction.commit();
  return outside;
}

}  // namespace

std::int64_t NightStore::add(const NightRecord& night) {
  const Store::WriteLease writer = store_.write();
  const std::string config = night.config.dump();
  const std::string now = utc_now();
  Statement insert(writer.connection(),
                   "INSERT INTO nights (name, status, started_utc, build, config, baseline, baseline_night, commit_id) "
                   "VALUES (?, 'running', ?, ?, ?, ?, ?, ?)");
  insert.bind(night.name)
      .bind(now)
      .bind(night.build)
      .bind(config)
      .bind(night.baseline)
      .bind(night.baseline_night)
      .bind(night.commit)
      .run();
  return writer.connection().last_insert_id();
}

void NightStore::add_capture(std::int64_t night, std::uint32_t ordinal, const NightCapture& capture) {
  const Store::WriteLease writer = store_.write();
  std::optional<std::string> head;
  if (capture.head) head = replay::to_json(*capture.head).dump();
  Statement(writer.connection(),
            "INSERT INTO night_captures (night, ordinal, name, source, hash, problem, head) VALUES (?, ?, ?, ?, ?, ?, "
            "?)")
      .bind(night)
      .bind(std::int64_t{ordinal})
      .bind(capture.name)
      .bind(capture.source)
      .bind(capture.hash)
      .bind(capture.problem)
      .bind(head)
      .run();
}

std::int64_t NightStore::add_cell(std::int64_t night, const NightCell& cell) {
  const Store::WriteLease writer = store_.write();
  const std::string gates = server::to_json(cell.gates).dump();
  const std::string time = server::to_json(cell.time).dump();
  Statement(writer.connection(),
            "INSERT INTO night_cells (night, capture, technique, status, gates, time) VALUES (?, ?, ?, ?, ?, ?)")
      .bind(night)
      .bind(std::int64_t{cell.capture})
      .bind(cell.technique)
      .bind(to_text(cell.status))
      .bind(gates)
      .bind(time)
      .run();
  return writer.connection().last_insert_id();
}

NightFrame NightStore::add_frame(std::int64_t cell, const replay::FrameResult& result,
                                 const std::map<std::string, Blob>& images) {
  const Store::WriteLease writer = store_.write();
  Transaction transaction(writer.connection());
  NightFrame frame;
  frame.result = result;
  frame.result.images.clear();
  for (const auto& [role, blob] : images) frame.result.images[role] = store_.store_blob(writer.connection(), blob);
  const std::string document = replay::to_json(frame.result).dump();
  Statement(writer.connection(), "INSERT INTO night_frames (cell, frame, document) VALUES (?, ?, ?)")
      .bind(cell)
      .bind(std::int64_t{result.frame})
      .bind(document)
      .run();
  frame.id = writer.connection().last_insert_id();
  for (const auto& [role, hash] : frame.result.images) insert_image(writer.connection(), frame.id, role, hash);
  transaction.commit();
  return frame;
}

std::string NightStore::add_difference(std::int64_t frame, const Blob& image) {
  const Store::WriteLease writer = store_.write();
  Transaction transaction(writer.connection());
  std::string hash = store_.store_blob(writer.connection(), image);
  insert_image(writer.connection(), frame, "difference", hash);
  transaction.commit();
  return hash;
}

void NightStore::update_cell(const NightCell& cell) {
  const Store::WriteLease writer = store_.write();
  const std::string gates = server::to_json(cell.gates).dump();
  const std::string time = server::to_json(cell.time).dump();
  Statement(writer.connection(), "UPDATE night_cells SET status = ?, gates = ?, time = ? WHERE id = ?")
      .bind(to_text(cell.status))
      .bind(gates)
      .bind(time)
      .bind(cell.id)
      .run();
}

void NightStore::set_facts(std::int64_t night, const json& facts) {
  const Store::WriteLease writer = store_.write();
  const std::string text = facts.dump();
  Statement(writer.connection(), "UPDATE nights SET facts = ? WHERE id = ?").bind(text).bind(night).run();
}

void NightStore::finish(std::int64_t id, NightStatus status, std::string_view reason) {
  const Store::WriteLease writer = store_.write();
  const std::string now = utc_now();
  Statement(writer.connection(), "UPDATE nights SET status = ?, reason = ?, finished_utc = ? WHERE id = ?")
      .bind(to_text(status))
      .bind(reason)
      .bind(now)
      .bind(id)
      .run();
}

void NightStore::interrupt_running(std::string_view reason) {
  const Store::WriteLease writer = store_.write();
  Statement(writer.connection(), "UPDATE nights SET status = 'interrupted', reason = ? WHERE status = 'running'")
      .bind(reason)
      .run();
}

void NightStore::drop_old(std::string_view name, std::uint32_t keep) {
  std::vector<std::string> outside;
  {
    const Store::WriteLease writer = store_.write();
    outside = drop_rows(writer.connection(), name, keep);
  }
  store_.remove_outside(outside);
}

std::optional<NightRecord> NightStore::night(std::int64_t id, bool with_frames) const {
  const Store::ReadLease reader = store_.read();
  std::optional<NightRecord> night;
  {
    Statement select(reader.connection(), std::string(kNightColumns) + "WHERE id = ?");
    select.bind(id);
    if (!select.step()) return std::nullopt;
    night = read_night(select);
  }
  read_captures(reader.connection(), *night);
  read_cells(reader.connection(), *night);
  if (with_frames) {
    for (NightCell& cell : night->cells) read_frames(reader.connection(), cell);
  }
  return night;
}

std::optional<NightCell> NightStore::cell(std::int64_t id) const {
  const Store::ReadLease reader = store_.read();
  std::optional<NightCell> cell;
  {
    Statement select(reader.connection(), std::string(kCellColumns) + "WHERE id = ?");
    select.bind(id);
    if (!select.step()) return std::nullopt;
    cell = read_cell(select);
  }
  read_frames(reader.connection(), *cell);
  return cell;
}

std::vector<NightRecord> NightStore::nights(std::uint32_t limit, std::int64_t before, std::string_view name) const {
  const Store::ReadLease reader = store_.read();
  std::string sql = std::string(kNightColumns) + "WHERE 1";
  if (before > 0) sql += " AND id < ?";
  if (!name.empty()) sql += " AND name = ?";
  Statement select(reader.connection(), sql + " ORDER BY id DESC LIMIT ?");
  if (before > 0) select.bind(before);
  if (!name.empty()) select.bind(name);
  select.bind(std::int64_t{limit});
  std::vector<NightRecord> nights;
  while (select.step()) nights.push_back(read_night(select));
  for (NightRecord& night : nights) {
    read_captures(reader.connection(), night);
    read_cells(reader.connection(), night);
  }
  return nights;
}

std::vector<NightRecord> NightStore::nights_of_cell(std::string_view name, std::string_view capture,
                                                    std::string_view technique, std::uint32_t limit) const {
  const Store::ReadLease reader = store_.read();
  std::vector<std::pair<std::int64_t, std::int64_t>> found;  // night and cell
  {
    Statement select(reader.connection(),
                     "SELECT n.id, c.id FROM nights n JOIN night_captures k ON k.night = n.id AND k.name = ? "
                     "JOIN night_cells c ON c.night = n.id AND c.capture = k.ordinal AND c.technique = ? "
                     "WHERE n.name = ? AND n.status IN ('passed', 'failed') AND c.status <> 'missing' "
                     "ORDER BY n.id DESC LIMIT ?");
    select.bind(capture).bind(technique).bind(name).bind(std::int64_t{limit});
    while (select.step()) {
      const std::int64_t night = select.integer();
      found.emplace_back(night, select.integer());
    }
  }
  std::vector<NightRecord> nights;
  for (const auto& [night_id, cell_id] : found) {
    Statement row(reader.connection(), std::string(kNightColumns) + "WHERE id = ?");
    row.bind(night_id);
    Statement cell_row(reader.connection(), std::string(kCellColumns) + "WHERE id = ?");
    cell_row.bind(cell_id);
    if (!row.step() || !cell_row.step()) continue;  // deleted meanwhile
    NightRecord night = read_night(row);
    NightCell cell = read_cell(cell_row);
    read_captures(reader.connection(), night);
    night.captures = {night.captures.at(cell.capture)};
    cell.capture = 0;
    read_frames(reader.connection(), cell);
    night.cells.push_back(std::move(cell));
    nights.push_back(std::move(night));
  }
  return nights;
}

bool NightStore::set_baseline(std::string_view name, std::int64_t night, std::string_view who, std::string_view why) {
  const Store::WriteLease writer = store_.write();
  Transaction transaction(writer.connection());
  const std::string now = utc_now();
  Statement(writer.connection(),
            "INSERT INTO baselines (name, night, set_utc) SELECT ?, id, ? FROM nights WHERE id = ? AND status IN "
            "('passed', 'failed') ON CONFLICT (name) DO UPDATE SET night = excluded.night, set_utc = excluded.set_utc")
      .bind(name)
      .bind(now)
      .bind(night)
      .run();
  if (writer.connection().changes() == 0) return false;
  Statement(writer.connection(), "INSERT INTO approvals (baseline, night, who, why, set_utc) VALUES (?, ?, ?, ?, ?)")
      .bind(name)
      .bind(night)
      .bind(who)
      .bind(why)
      .bind(now)
      .run();
  transaction.commit();
  return true;
}

namespace {

std::vector<BaselineRecord> read_baselines(Statement& select) {
  std::vector<BaselineRecord> baselines;
  while (select.step()) {
    BaselineRecord baseline;
    baseline.name = select.text();
    baseline.night = select.integer();
    baseline.set_utc = select.text();
    baseline.who = select.text();
    baseline.why = select.text();
    baselines.push_back(std::move(baseline));
  }
  return baselines;
}

}  // namespace

std::vector<BaselineRecord> NightStore::baselines() const {
  const Store::ReadLease reader = store_.read();
  Statement select(reader.connection(),
                   "SELECT b.name, b.night, b.set_utc, a.who, a.why FROM baselines b LEFT JOIN approvals a ON a.id = "
                   "(SELECT max(id) FROM approvals WHERE baseline = b.name) ORDER BY b.name");
  return read_baselines(select);
}

std::vector<BaselineRecord> NightStore::approvals(std::string_view name) const {
  const Store::ReadLease reader = store_.read();
  Statement select(
      reader.connection(),
      "SELECT baseline, night, set_utc, who, why FROM approvals WHERE ?1 = '' OR baseline = ?1 ORDER BY id "
      "DESC");
  select.bind(name);
  return read_baselines(select);
}

}  // namespace subpixel::server
