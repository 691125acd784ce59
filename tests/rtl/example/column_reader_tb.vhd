-- Plays the packets of a co-simulation to column_reader, with pauses, and compares the columns that it gives.
--
--   selfproj-sim cosim ... --vectors DIR
--   ghdl -a --std=08 rtl/common/sp_spec_pkg.vhd column_reader.vhd column_reader_tb.vhd
--   ghdl --elab-run --std=08 column_reader_tb -gFOLDER=DIR
--
-- The files are described in sim/cosim/vector_files.h.
library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;
use ieee.math_real.all;

library std;
use std.textio.all;

entity column_reader_tb is
  generic (FOLDER : string := ".");
end entity;

architecture bench of column_reader_tb is

  signal clk                    : std_ulogic := '0';
  signal rst                    : std_ulogic := '1';
  signal valid, ready, last     : std_ulogic := '0';
  signal data                   : std_ulogic_vector(127 downto 0) := (others => '0');
  signal column_valid           : std_ulogic;
  signal m0                     : unsigned(17 downto 0);
  signal m1                     : unsigned(26 downto 0);
  signal done, good             : std_ulogic;
  signal finished               : boolean := false;
  signal columns, packets       : natural := 0;

  -- The next line that is no comment; empty at the end of the file.
  procedure read_line(file from : text; variable words : inout line) is
  begin
    deallocate(words);
    while not endfile(from) loop
      readline(from, words);
      exit when words'length > 0 and words(words'low) /= '/';
      deallocate(words);
    end loop;
  end procedure;

begin

  clk <= not clk after 4 ns when not finished else '0';

  u_reader : entity work.column_reader
    port map (
      clk_i => clk, rst_i => rst, s_axis_tvalid => valid, s_axis_tready => ready, s_axis_tdata => data,
      s_axis_tlast => last, column_valid_o => column_valid, column_m0_o => m0, column_m1_o => m1, done_o => done,
      good_o => good);

  play : process
    file from              : text open read_mode is FOLDER & "/packets.hex";
    variable words         : line;
    variable flags         : std_ulogic_vector(7 downto 0);
    variable beat          : std_ulogic_vector(127 downto 0);
    variable seed1, seed2  : positive := 1;
    variable chance        : real;
  begin
    wait until rising_edge(clk);
    rst <= '0';
    loop
      read_line(from, words);
      exit when words = null;
      hread(words, flags);
      hread(words, beat);
      loop  -- pauses
        uniform(seed1, seed2, chance);
        exit when chance < 0.7;
        wait until rising_edge(clk);
      end loop;
      valid <= '1';
      data  <= beat;
      last  <= flags(0);
      wait until rising_edge(clk) and ready = '1';
      valid <= '0';
    end loop;
    for i in 1 to 10 loop
      wait until rising_edge(clk);
    end loop;
    finished <= true;
    wait;
  end process;

  compare : process
    file from          : text open read_mode is FOLDER & "/columns.hex";
    variable words     : line;
    variable want_m0   : std_ulogic_vector(31 downto 0);
    variable want_m1   : std_ulogic_vector(31 downto 0);
  begin
    loop
      wait until rising_edge(clk) or finished;
      exit when finished;
      if done = '1' then
        packets <= packets + 1;
        assert good = '1' report "a packet says that its frame is broken" severity failure;
      end if;
      if column_valid = '1' then
        columns <= columns + 1;
        read_line(from, words);
        assert words /= null report "there are more columns than in columns.hex" severity failure;
        hread(words, want_m0);
        hread(words, want_m1);
        assert m0 = unsigned(want_m0) and m1 = unsigned(want_m1)
          report "column " & to_string(columns + 1) & ": m0 " & to_string(to_integer(m0)) & ", m1 " &
                 to_string(to_integer(m1)) & ", expected " & to_string(to_integer(unsigned(want_m0))) & ", " &
                 to_string(to_integer(unsigned(want_m1)))
          severity failure;
      end if;
    end loop;
    read_line(from, words);
    assert words = null report "columns are missing" severity failure;
    report to_string(columns) & " columns in " & to_string(packets) & " packets as expected";
    wait;
  end process;

end architecture;
