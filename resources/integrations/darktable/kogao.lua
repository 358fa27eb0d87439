-- Kogao for darktable: two targets of the export module. Photos are exported (choose TIFF, 16 bits),
-- worked on by Kogao, and come back beside the originals, grouped with them.
-- Installed by `kogao-cli integrate darktable`, which fills in where the programs lie.

local dt = require "darktable"

-- Within a Flatpak: out of its sandbox, whose /tmp nobody else sees; its cache is a usual folder.
local SANDBOXED = os.getenv("FLATPAK_ID") ~= nil
local OUT = SANDBOXED and "flatpak-spawn --host " or ""
local EDITOR = OUT .. "@KOGAO@ --edit --temporary"
local BY_ITSELF = OUT .. "@KOGAO_CLI@ warp --in-place --temporary"

local function quoted(path)
  if dt.configuration.running_os == "windows" then
    return '"' .. path .. '"'
  end
  return "'" .. path:gsub("'", "'\\''") .. "'"
end

local function is_there(path)
  local file = io.open(path, "rb")
  if file then
    file:close()
  end
  return file ~= nil
end

-- A name beside the photo that nobody has yet.
local function free_name(image, exported)
  local stem = image.path .. "/" .. image.filename:gsub("%.[^.]*$", "") .. "_kogao"
  local ending = exported:match("%.[^.]*$") or ""
  local name, number = stem .. ending, 1
  while is_there(name) do
    name, number = stem .. "_" .. number .. ending, number + 1
  end
  return name
end

local function copied(from, to)
  local source = assert(io.open(from, "rb"))
  local data = source:read("a")
  source:close()
  local target = assert(io.open(to, "wb"))
  target:write(data)
  target:close()
end

-- The exported file where a program outside can reach it.
local function within_reach(file)
  if not SANDBOXED then
    return file
  end
  local moved = os.getenv("XDG_CACHE_HOME") .. "/" .. file:match("[^/]*$")
  copied(file, moved)
  os.remove(file)
  return moved
end

-- Run a command on exported files; import those that it was done for, each grouped with its photo.
local function bring_back(command, exported)
  for image, given in pairs(exported) do
    local file = within_reach(given)
    local code = dt.control.execute(command .. " " .. quoted(file))
    if code == 0 then
      local name = free_name(image, file)
      copied(file, name)
      local result = dt.database.import(name)
      result:group_with(image.group_leader)
      result.rating = image.rating
      for _, tag in ipairs(image:get_tags()) do
        if not tag.name:match("^darktable|") then
          result:attach_tag(tag)
        end
      end
    elseif code ~= 6 then -- 6: closed without saving
      dt.print("Kogao: " .. image.filename .. " wasn't done (code " .. tostring(code) .. ")")
    end
    os.remove(file)
  end
end

local function register(name, label, command)
  dt.register_storage(name, label, nil, function(_, exported)
    bring_back(command, exported)
  end)
end

register("kogao_editor", "Kogao: edit", EDITOR)
register("kogao_by_itself", "Kogao: smaller faces", BY_ITSELF)

return { bring_back = bring_back, EDITOR = EDITOR, BY_ITSELF = BY_ITSELF }
