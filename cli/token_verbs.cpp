#include "cli/token_verbs.hpp"

#include <fmt/format.h>

#include <memory>
#include <optional>
#include <string>

#include "base/error.hpp"
#include "base/json_text.hpp"
#include "base/printable.hpp"
#include "server/store/data_folder.hpp"
#include "server/store/tokens.hpp"

namespace subpixel::cli {
namespace {

using server::DataFolder;

struct TokenArguments {
  std::string data = "subpixel-data", name, right = "read";
  std::optional<double> quota_gb;
  std::optional<std::uint32_t> days;
  bool as_json = false;
};

int add_token(const TokenArguments& arguments) {
  const DataFolder folder(arguments.data, DataFolder::Claim::reader);
  server::Store store(folder.store());
  std::optional<std::uint64_t> quota;
  if (arguments.quota_gb) quota = static_cast<std::uint64_t>(*arguments.quota_gb * (1 << 30));
  fmt::print("{}\n", server::TokenStore(store).add(arguments.name, server::right_from_text(arguments.right), quota,
                                                   arguments.days));
  return 0;
}

int list_tokens(const TokenArguments& arguments) {
  const DataFolder folder(arguments.data, DataFolder::Claim::reader);
  server::Store store(folder.store());
  nlohmann::json list = nlohmann::json::array();
  for (const server::TokenRecord& token : server::TokenStore(store).list()) {
    const std::string state = !token.revoked_utc.empty()  ? "revoked " + token.revoked_utc
                              : token.expires_utc.empty() ? "for good"
                                                          : "until " + token.expires_utc;
    if (!arguments.as_json) {
      const std::string quota = token.quota_bytes ? fmt::format(" of {}", *token.quota_bytes) : "";
      fmt::print("{:<20} {:<8} made {}, {}; sent {}{} bytes\n", printable(token.name), to_text(token.right),
                 token.created_utc, state, token.uploaded_bytes, quota);
    }
    list.push_back({{"name", token.name},
                    {"right", to_text(token.right)},
                    {"quota_bytes", token.quota_bytes ? nlohmann::json(*token.quota_bytes) : nlohmann::json(nullptr)},
                    {"uploaded_bytes", token.uploaded_bytes},
                    {"created_utc", token.created_utc},
                    {"expires_utc", token.expires_utc},
                    {"revoked_utc", token.revoked_utc}});
  }
  if (arguments.as_json) fmt::print("{}\n", json_text(list, 1));
  return 0;
}

int revoke_token(const TokenArguments& arguments) {
  const DataFolder folder(arguments.data, DataFolder::Claim::reader);
  server::Store store(folder.store());
  if (!server::TokenStore(store).revoke(arguments.name)) {
    throw InputError("token", "none of this name is in force", arguments.name);
  }
  return 0;
}

}  // namespace

void add_token_verbs(CLI::App& app, std::function<int()>& action) {
  const auto arguments = std::make_shared<TokenArguments>();
  CLI::App* const verb = app.add_subcommand("token", "Make, list and revoke the tokens of a service");
  verb->require_subcommand(1);
  const auto add = [&](const char* name, const char* description, bool named, int (*run)(const TokenArguments&)) {
    CLI::App* const part = verb->add_subcommand(name, description);
    if (named) part->add_option("name", arguments->name, "Whose token it is")->required();
    part->add_option("--data", arguments->data, "Data folder")->capture_default_str();
    part->callback([arguments, run, &action] { action = [arguments, run] { return run(*arguments); }; });
    return part;
  };
  CLI::App* const making = add("add", "Make a token and print it, once: only its hash is stored", true, &add_token);
  making->add_option("--rights", arguments->right, "read, submit, approve or admin; each may what those before may")
      ->check(CLI::IsMember({"read", "submit", "approve", "admin"}))
      ->capture_default_str();
  making->add_option("--quota", arguments->quota_gb, "GiB of captures that may be sent with it; default: no limit")
      ->check(CLI::Range(0.0, 1024.0 * 1024));
  making->add_option("--days", arguments->days, "Days until it expires; default: never")->check(CLI::Range(1, 36500));
  add("list", "List all tokens there have been", false, &list_tokens)
      ->add_flag("--json", arguments->as_json, "Print one JSON document");
  add("revoke", "Take a token out of force, at once also of a running service", true, &revoke_token);
}

}  // namespace subpixel::cli
